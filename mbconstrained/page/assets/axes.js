// An axis, linear or logarithmic, of which a part is shown. The ticks are those of axis.py.
const mostSteps = 6;
const fewDecades = 2;
const fewestTicks = 3;
const noiseSpan = 1e-9;
const letter = 7.4; // width of a letter of a label, px
const labelSpace = 8; // between two labels, px
const [margin, marginLetters] = [70, 6]; // the usual margin on the left, px, and the letters of labels that it has room for

class Axis {
  constructor(ends, unit) {
    const [low, high, exponent, scale] = ends.split(" ");
    this.log = scale === "log";
    this.rows = scale === "rows"; // whole numbers that stand for names
    this.unit = unit;
    this.exponent = Number(exponent);
    this.whole = [Number(low), Number(high)];
    this.from = this.scaled(this.whole[0]);
    this.span = this.scaled(this.whole[1]) - this.from;
    this.reset();
  }

  scaled(value) {
    return this.log ? Math.log10(Math.max(value, this.whole[0])) : value;
  }

  reset() {
    this.view = [0, 1]; // the part of the axis that is shown
  }

  get zoomed() {
    return this.view[1] - this.view[0] < 1;
  }

  // Where a value is in the part that is shown: 0 at its low end, 1 at its high end.
  share(value) {
    return ((this.scaled(value) - this.from) / this.span - this.view[0]) / (this.view[1] - this.view[0]);
  }

  value(share) {
    const scaled = this.from + this.span * (this.view[0] + share * (this.view[1] - this.view[0]));
    return this.log ? 10 ** scaled : scaled;
  }

  get ends() {
    return this.zoomed ? [this.value(0), this.value(1)] : this.whole;
  }

  // Shows a smaller or larger part, in which the same value is at a share.
  zoom(factor, share) {
    const size = this.view[1] - this.view[0];
    const next = Math.min(1, Math.max(smallestPart, size / factor));
    this.show(this.view[0] + share * (size - next), next);
  }

  // Moves the part that is shown by a share of it.
  pan(share) {
    const size = this.view[1] - this.view[0];
    this.show(this.view[0] + share * size, size);
  }

  // Shows a part of a size, as near to a low end as the whole allows.
  show(low, size) {
    const start = Math.min(1 - size, Math.max(0, low));
    this.view = [start, start + size];
  }

  // Values and texts of the ticks.
  ticks() {
    if (this.rows) return [];
    return this.log ? logTicks(...this.ends) : linearTicks(...this.ends, this.exponent);
  }

  // Those of some ticks whose labels do not meet on an axis of this width: all, powers of ten, or some at even steps.
  labelled(ticks, width) {
    const powers = this.log ? ticks.filter(([value]) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < noiseSpan) : ticks;
    const steps = ticks.map((_, i) => (powers.length ? powers : ticks).filter((_, place) => place % (i + 1) === 0));
    const clear = (kept) => kept.every((tick, i) => {
      if (i === 0) return true;
      const [before, letters] = [kept[i - 1], (kept[i - 1][1].length + tick[1].length) / 2];
      return width * (this.share(tick[0]) - this.share(before[0])) >= letter * letters + labelSpace;
    });
    return [ticks, ...steps].find(clear) || [];
  }

  // A value to a part of a pixel, rounded to what its text shows.
  rounded(value, pixels) {
    const [low, high] = this.ends;
    const resolution = this.log ? (value * Math.log(high / low)) / pixels : (high - low) / pixels;
    const digits = Math.min(12, Math.max(0, this.exponent - Math.floor(Math.log10(resolution))));
    return { value: Number((value / 10 ** this.exponent).toFixed(digits)) * 10 ** this.exponent, digits: digits };
  }

  text(value, digits) {
    const number = fixed(value / 10 ** this.exponent, digits);
    return numberWithUnit(this.exponent ? `${number}·10${superscript(this.exponent)}` : number, this.unit);
  }
}

const smallestPart = 1e-5;

function stepOf(span) {
  const rough = span / mostSteps;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * [1, 2, 5, 10].find((factor) => rough <= factor * power * (1 + noiseSpan));
}

function multiples(low, high, step) {
  const first = Math.ceil(low / step - noiseSpan);
  const last = Math.floor(high / step + noiseSpan);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

function linearTicks(low, high, exponent) {
  const step = stepOf(high - low);
  const digits = Math.min(100, Math.max(0, exponent - Math.floor(Math.log10(step) + noiseSpan)));
  return multiples(low, high, step).map((tick) => [tick, fixed(tick / 10 ** exponent, digits)]);
}

function logTicks(low, high) {
  const first = Math.ceil(Math.log10(low) - noiseSpan);
  const last = Math.floor(Math.log10(high) + noiseSpan);
  const stride = Math.max(1, Math.ceil((last - first) / mostSteps));
  const factors = last - first <= fewDecades ? [1, 2, 5] : [1];
  let ticks = [];
  for (let k = first - 1; k <= last; k++) {
    if (k % stride === 0) ticks.push(...factors.map((factor) => factor * 10 ** k));
  }
  ticks = ticks.filter((tick) => tick >= low * (1 - noiseSpan) && tick <= high * (1 + noiseSpan));
  if (ticks.length < fewestTicks) ticks = multiples(low, high, stepOf(high - low));
  return ticks.map((tick) => [tick, logLabel(tick)]);
}

function logLabel(value) {
  const power = Math.floor(Math.log10(value) + noiseSpan);
  if (power >= -3 && power <= 4) return String(Number(value.toPrecision(12)));
  const factor = value / 10 ** power;
  return `${Math.abs(factor - 1) < 1e-6 ? "" : `${Number(factor.toPrecision(6))}·`}10${superscript(power)}`;
}
