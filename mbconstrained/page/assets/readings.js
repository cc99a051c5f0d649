// Functions of time, in parts one after the other: each has a value with a bound of its error at any time.
class TimeFunctions {
  constructor(parts) {
    this.parts = parts;
  }

  // At a time where one ends the later part.
  at(row, time) {
    let [i, part] = [this.parts.length - 1, null];
    for (part = this.parts[i]; i > 0 && time < part.start; part = this.parts[i]) i--;
    return part.at(row, time);
  }

  // The computed points, between which there is nothing but straight lines; null for functions.
  get samples() {
    return this.parts.length === 1 && this.parts[0].linear ? this.parts[0] : null;
  }

  // Times at which a function is drawn between two times: as close as is asked for, or those of the stored values.
  timesBetween(from, to, spacing) {
    const times = [from];
    for (const part of this.parts) {
      const [begin, end] = [Math.max(from, part.start), Math.min(to, part.end)];
      if (begin < end) part.timesBetween(begin, end, spacing).forEach((time) => times.push(time));
    }
    times.push(to);
    return times;
  }
}

function functionsOf(packed) {
  const records = packed.records.map((each) => new RecordSteps(each));
  const part = (each) => (each.steps === undefined ? new Panels(each) : new RecordFunctions(each, records[each.steps]));
  return packed.sets.map((parts) => new TimeFunctions(parts.map(part)));
}

// On each of some panels a polynomial, by its values at Chebyshev points. A value is a whole number of steps;
// the step is a power of two of its own for each function and panel, and no value is off by more than a bound of some steps.
const bounds = { 0: 1, 2: 1, 4: 2, 8: 2, 16: 2 }; // by the degree

class Panels {
  constructor(packed) {
    [this.start, this.end] = [packed.start, packed.end];
    this.degrees = unpack(packed.degrees, Uint8Array);
    this.count = this.degrees.length;
    this.edges = new Float64Array(this.count + 1);
    this.edges.set([packed.start]);
    if (packed.edges !== undefined) this.edges.set(unpack(packed.edges, Float64Array), 1);
    else unpack(packed.counts, Uint16Array).reduce((sum, gap, i) => (this.edges[i + 1] = Math.min(packed.end, packed.start + packed.unit * (sum + gap)), sum + gap), 0);
    this.edges[this.count] = packed.end;
    this.exponents = unpack(packed.exponents, Uint8Array);
    this.base = packed.base;
    this.codes = wholeNumbers(unpack(packed.codes, Uint8Array), packed.bytes);
    this.places = new Uint32Array(this.count + 1);
    this.degrees.forEach((degree, i) => (this.places[i + 1] = this.places[i] + degree + 1));
  }

  // Whether the values are points with straight lines from each to the next.
  get linear() {
    return this.degrees.every((degree) => degree === 0);
  }

  // The computed points on both sides of a time; none where all functions are constant between them.
  around(time) {
    const panel = this.panel(time);
    const rows = Array.from({ length: this.codes.length / this.count }, (_, row) => row);
    const value = (row, at) => this.codes[this.place(row, at)] * this.step(row, at);
    const next = Math.min(panel + 1, this.count - 1);
    return next > panel && rows.every((row) => value(row, panel) === value(row, next)) ? [] : [this.edges[panel], this.edges[next]];
  }

  points(from, to) {
    return [...this.edges.subarray(0, this.count)].filter((time) => time >= from && time <= to);
  }

  // The panel of a time; at an edge the later one.
  panel(time) {
    return lastBefore(this.edges, time, this.count);
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
    return [step * interpolated(degree, x, (j) => this.codes[place + j]), bounds[degree] * step];
  }

  // A panel of degree 0 is a line to the value of the next one.
  onLine(row, panel, share) {
    const next = Math.min(panel + 1, this.count - 1);
    const [here, there] = [panel, next].map((each) => this.codes[this.place(row, each)] * this.step(row, each));
    return [here + share * (there - here), Math.max(this.step(row, panel), this.step(row, next))];
  }

  timesBetween(from, to, spacing) {
    const times = [];
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
    return times;
  }
}

// A motion from sample to sample of a record: its coordinates at the first sample of each block are stored, and a matrix takes those
// at one sample, with the samples around, to those at the next.
class RecordSteps {
  constructor(packed) {
    Object.assign(this, packed);
    this.samples = unpack(packed.samples, Float32Array);
    this.first = unpack(packed.first, Float64Array);
    this.matrix = unpack(packed.matrix, Float64Array);
    this.size = this.first.length / Math.ceil(this.count / this.block);
    this.number = -1; // of the block that is computed
    this.coordinates = new Float64Array(this.block * this.size);
  }

  sample(force, gap) {
    return this.samples[force * (this.count + 1) + Math.min(gap, this.count)];
  }

  compute(number) {
    const { size, block, forces, coordinates, matrix } = this;
    this.number = number;
    coordinates.set(this.first.subarray(number * size, (number + 1) * size));
    for (let i = 0; i + 1 < Math.min(block, this.count - number * block); i++) {
      const inputs = [...coordinates.subarray(i * size, (i + 1) * size)];
      for (let after = 0; after < 3; after++) for (let force = 0; force < forces; force++) inputs.push(this.sample(force, number * block + i + after));
      inputs.push(1);
      for (let row = 0; row < size; row++) coordinates[(i + 1) * size + row] = product(matrix, row * inputs.length, inputs);
    }
  }

  // Coordinates and samples of a gap, and 1.
  features(gap) {
    const number = Math.floor(gap / this.block);
    if (number !== this.number) this.compute(number);
    const at = gap - number * this.block;
    const features = [...this.coordinates.subarray(at * this.size, (at + 1) * this.size)];
    for (let after = 0; after < 2; after++) for (let force = 0; force < this.forces; force++) features.push(this.sample(force, gap + after));
    return [...features, 1];
  }
}

// Between two samples a polynomial whose values at the Chebyshev points are linear in the features of the gap, or in their products.
class RecordFunctions {
  constructor(packed, steps) {
    [this.steps, this.degree, this.quadratic] = [steps, packed.degree, packed.quadratic];
    [this.start, this.end] = [steps.start, steps.start + steps.count * steps.gap];
    this.rows = unpack(packed.rows, Float64Array);
    this.bounds = unpack(packed.bounds, Int16Array);
    this.blocks = Math.ceil(steps.count / steps.block);
    this.gap = -1; // the one of the inputs
  }

  at(row, time) {
    const { steps, degree } = this;
    const gap = Math.min(steps.count - 1, Math.max(0, Math.floor((time - this.start) / steps.gap)));
    const x = Math.min(1, Math.max(-1, (2 * (time - this.start)) / steps.gap - 2 * gap - 1));
    if (gap !== this.gap) {
      this.gap = gap;
      this.inputs = this.quadratic ? productsOfTwo(steps.features(gap)) : steps.features(gap);
    }
    const count = this.rows.length / (degree + 1);
    const value = interpolated(degree, x, (j) => product(this.rows, j * count + row * this.inputs.length, this.inputs));
    return [value, 2 ** this.bounds[row * this.blocks + Math.floor(gap / steps.block)]];
  }

  timesBetween(from, to, spacing) {
    const { steps, start } = this;
    const parts = Math.min(4000, Math.max(2, Math.ceil(steps.gap / spacing)));
    const times = [];
    for (let gap = Math.max(0, Math.floor((from - start) / steps.gap)); gap < steps.count && start + gap * steps.gap < to; gap++) {
      for (let i = 0; i <= parts; i++) {
        const time = start + steps.gap * (gap + (i === parts ? 1 - 1e-6 : i / parts)); // before a jump
        if (time >= from && time <= to) times.push(time);
      }
    }
    return times;
  }
}

function product(matrix, place, inputs) {
  let sum = 0;
  for (let i = 0; i < inputs.length; i++) sum += matrix[place + i] * inputs[i];
  return sum;
}

function productsOfTwo(numbers) {
  return numbers.flatMap((one, i) => numbers.slice(i).map((other) => one * other));
}

// The value of a polynomial at x from its values at the Chebyshev points, by the barycentric formula.
function interpolated(degree, x, value) {
  let [above, below] = [0, 0];
  for (let j = 0; j <= degree; j++) {
    const distance = x - chebyshev[degree][j];
    if (distance === 0) return value(j);
    const weight = (j % 2 ? -1 : 1) / (j === 0 || j === degree ? 2 : 1) / distance;
    above += weight * value(j);
    below += weight;
  }
  return above / below;
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
