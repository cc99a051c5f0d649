// Numbers packed as base64.
function unpack(text, Type) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Type(bytes.buffer);
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
