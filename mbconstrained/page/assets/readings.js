// Functions of time: on each of some panels a polynomial, by its values at Chebyshev points. A value is a whole number of steps;
// the step is a power of two of its own for each function and panel, and no value is off by more than a bound of some steps.
const bounds = { 0: 1, 2: 1, 4: 2, 8: 2, 16: 2 }; // by the degree

class TimeFunctions {
  constructor(packed) {
    this.degrees = unpack(packed.degrees, Uint8Array);
    this.count = this.degrees.length;
    this.edges = new Float64Array(this.count + 1);
    this.edges.set([packed.start]);
    if (packed.edges !== undefined) this.edges.set(unpack(packed.edges, Float64Array), 1);
    else unpack(packed.counts, Uint16Array).reduce((sum, gap, i) => (this.edges[i + 1] = packed.start + packed.unit * (sum + gap), sum + gap), 0);
    this.edges[this.count] = packed.end;
    this.exponents = unpack(packed.exponents, Uint8Array);
    this.base = packed.base;
    this.codes = wholeNumbers(unpack(packed.codes, Uint8Array), packed.bytes);
    this.places = new Uint32Array(this.count + 1);
    this.degrees.forEach((degree, i) => (this.places[i + 1] = this.places[i] + degree + 1));
  }

  // The panel of a time; at an edge the later one.
  panel(time) {
    let [low, high] = [0, this.count];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.edges[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  step(row, panel) {
    return 2 ** (this.base + this.exponents[row * this.count + panel]);
  }

  // Where the values of a function in a panel begin.
  place(row, panel) {
    return row * this.places[this.count] + this.places[panel];
  }

  // Value and bound of its error, by the barycentric formula.
  at(row, time, panel = this.panel(time)) {
    const [left, right] = [this.edges[panel], this.edges[panel + 1]];
    const [degree, place, step] = [this.degrees[panel], this.place(row, panel), this.step(row, panel)];
    const x = right > left ? Math.min(1, Math.max(-1, (2 * (time - left)) / (right - left) - 1)) : 1;
    if (degree === 0) return this.onLine(row, panel, (time - left) / (right - left || 1));
    let [above, below] = [0, 0];
    for (let j = 0; j <= degree; j++) {
      const distance = x - chebyshev[degree][j];
      if (distance === 0) return [this.codes[place + j] * step, bounds[degree] * step];
      const weight = (j % 2 ? -1 : 1) / (j === 0 || j === degree ? 2 : 1) / distance;
      above += weight * this.codes[place + j];
      below += weight;
    }
    return [(above / below) * step, bounds[degree] * step];
  }

  // A panel of degree 0 is a line to the value of the next one.
  onLine(row, panel, share) {
    const next = Math.min(panel + 1, this.count - 1);
    const [here, there] = [panel, next].map((each) => this.codes[this.place(row, each)] * this.step(row, each));
    return [here + share * (there - here), Math.max(this.step(row, panel), this.step(row, next))];
  }

  // Times at which a function is drawn between two times: as close as is asked for, or those of the stored values.
  timesBetween(from, to, spacing) {
    const times = [from];
    for (let panel = this.panel(from); panel < this.count && this.edges[panel] < to; panel++) {
      const [left, right] = [this.edges[panel], this.edges[panel + 1]];
      const degree = this.degrees[panel];
      const parts = degree === 0 ? 1 : Math.min(4000, Math.max(2, Math.ceil((Math.min(right, to) - Math.max(left, from)) / spacing)));
      const [begin, end] = degree === 0 ? [left, right] : [Math.max(left, from), Math.min(right, to)];
      for (let i = 0; i <= parts; i++) {
        const time = begin + ((end - begin) * i) / parts;
        if (time >= from && time <= to) times.push(i === parts ? time - 1e-9 * (end - begin) : time); // before a jump
      }
    }
    times.push(to);
    return times;
  }
}

const chebyshev = Object.fromEntries(
  Object.keys(bounds).map((degree) => [degree, Array.from({ length: Number(degree) + 1 }, (_, j) => -Math.cos((Math.PI * j) / degree))])
);

// Whole numbers with a sign, of some bytes each, the lowest first.
function wholeNumbers(bytes, size) {
  const numbers = new Int32Array(bytes.length / size);
  const unused = 32 - 8 * size;
  for (let i = 0; i < numbers.length; i++) {
    let code = 0;
    for (let k = 0; k < size; k++) code |= bytes[size * i + k] << (8 * k + unused);
    numbers[i] = code >> unused;
  }
  return numbers;
}

// A value with four digits, or with fewer where its error could change the last one; small and large ones with a power of ten.
// The exponent is that of the labels of the axis, in whose powers values of its size are given.
function readingText(value, error, unit, exponent) {
  for (let digits = 4; digits > 0; digits--) {
    const power = Math.floor(Math.log10(Math.abs(value))) - digits + 1;
    const [low, high] = [value - error, value + error].map((end) => Math.round(end / 10 ** power));
    if (value !== 0 && low === high && low !== 0) return numberWithUnit(decimalText(low, power, exponent), unit);
  }
  return numberWithUnit("0", unit);
}
