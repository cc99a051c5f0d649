// Numbers packed as base64.
function unpack(text, Type) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Type(bytes.buffer);
}

// The place of the last of ascending numbers that is not after a value, 0 where all are.
function lastBefore(numbers, value, count = numbers.length) {
  let [low, high] = [0, count];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (numbers[middle] <= value) low = middle;
    else high = middle;
  }
  return low;
}

// A number as a text with a true minus sign, which zero never has.
function fixed(number, digits) {
  return number.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "−");
}

// Saves a file of a name of which letters and digits are kept.
function saveFile(parts, type, name, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(parts, { type: type }));
  link.download = `${name.replace(/[^\p{L}\p{N}]+/gu, "_").slice(0, 100) || "motion"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  return link.download;
}

// A whole number times a power of ten.
function decimalText(number, power, exponent) {
  const digits = String(Math.abs(number));
  const sign = number < 0 ? "−" : "";
  const largest = digits.length - 1 + power - exponent;
  if (largest >= -4 && largest <= 4 && power <= exponent) {
    const value = (Math.abs(number) / 10 ** Math.max(0, exponent - power)).toFixed(exponent - power);
    return sign + value + (exponent ? `·10${superscript(exponent)}` : "");
  }
  const own = digits.length - 1 + power;
  const factor = digits.length > 1 ? `${digits[0]}.${digits.slice(1)}` : digits;
  return `${sign}${factor}${own ? `·10${superscript(own)}` : ""}`;
}

function numberWithUnit(number, unit) {
  return unit ? `${number} ${unit}` : number;
}

function superscript(number) {
  return String(number).replace(/[-0-9]/g, (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]);
}
