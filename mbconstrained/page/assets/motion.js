// The motion: each coordinate as a function of time, cubic between the key frames and exact on them; and the poses of
// bodies on paths, cubic too.

// Packed numbers, or a track: codes of 16 bits with the lowest value and the step of each row.
function unpacked(numbers, Type) {
  if (typeof numbers === "string") return unpack(numbers, Type);
  const { low, step, codes } = numbers;
  return Float64Array.from(unpack(codes, Uint16Array), (code, i) => low[i % low.length] + step[i % low.length] * code);
}

// Times one by one, or evenly spaced from the first to the last.
function timesOf(times) {
  if (typeof times === "string") return Array.from(unpack(times, Float64Array));
  const { start, end, count } = times;
  return Array.from({ length: count }, (_, i) => (count === 1 ? start : start + (i * (end - start)) / (count - 1)));
}

class Motion {
  // Per coordinate: its values at the key frames, or one number if it never changes; its rates, or 0, or null where they
  // are estimated. Per body: its poses, seven numbers each, or null.
  constructor(frames) {
    this.times = timesOf(frames.times);
    this.start = this.times[0];
    this.end = this.times[this.times.length - 1];
    this.windows = null;
    this.sides = this.sidesOfJumps();
    this.names = frames.names;
    const Type = frames.bytes === 8 ? Float64Array : Float32Array;
    const read = (numbers) => (typeof numbers === "number" ? numbers : unpacked(numbers, Type));
    this.values = frames.values.map(read);
    const estimated = (values) => (typeof values === "number" ? 0 : this.slopes(values, 0, 1));
    const rates = frames.rates || this.values.map(() => null);
    this.rates = rates.map((row, i) => (row === null ? estimated(this.values[i]) : read(row)));
    this.paths = frames.paths.map((poses) => poses && this.path(unpacked(poses, Float32Array)));
  }

  clamp(time) {
    return Math.min(this.end, Math.max(this.start, time));
  }

  // The values of all coordinates at a time, in the order of the names.
  at(time) {
    const key = this.keyBefore(time);
    return this.values.map((_, i) => this.value(i, time, key));
  }

  // The value of one coordinate.
  value(i, time, key = this.keyBefore(time)) {
    const values = this.values[i];
    return typeof values === "number" ? values : this.between(values, this.rates[i], key, time);
  }

  // Index of the last key frame that is not after the time, at most the last but one.
  keyBefore(time) {
    return lastBefore(this.times, time, this.times.length - 1);
  }

  // Cubic Hermite interpolation.
  between(values, rates, key, time, offset = 0, stride = 1) {
    const length = this.times[key + 1] - this.times[key];
    const s = (time - this.times[key]) / length;
    const r = 1 - s;
    const [a, b] = [stride * key + offset, stride * (key + 1) + offset];
    return (
      r * r * (1 + 2 * s) * values[a] + s * s * (1 + 2 * r) * values[b] + length * s * r * (r * rates[key] - s * rates[key + 1])
    );
  }

  path(poses) {
    if (poses.length === 7) return { constant: Array.from(poses) };
    return { poses: poses, rates: [0, 1, 2, 3, 4, 5, 6].map((row) => this.slopes(poses, row, 7)) };
  }

  // Position and unit quaternion of a body with a path.
  poseOnPath(body, time) {
    const { constant, poses, rates } = this.paths[body];
    const key = this.keyBefore(time);
    const pose = constant || rates.map((rate, row) => this.between(poses, rate, key, time, row, 7));
    const length = Math.hypot(...pose.slice(3));
    return { position: pose.slice(0, 3), quaternion: pose.slice(3).map((value) => value / length), turn: [0, 0, 0] };
  }

  // Derivatives at the key frames of the quartics through each five neighbours: of fourth order in their spacing.
  slopes(values, offset, stride) {
    this.windows = this.windows || this.times.map((_, key) => this.derivativeWeights(key));
    return this.windows.map(({ first, weights }) =>
      weights.reduce((sum, weight, k) => sum + weight * values[stride * (first + k) + offset], 0)
    );
  }

  // Where the times after jumps begin, and the end of all: two times that nearly coincide are the two sides of a jump.
  sidesOfJumps() {
    const least = (1e-9 * (this.end - this.start)) / Math.max(1, this.times.length - 1);
    const begins = this.times.map((_, key) => key).filter((key) => key && this.times[key] - this.times[key - 1] < least);
    return [0, ...begins, this.times.length];
  }

  derivativeWeights(key) {
    const next = this.sides.findIndex((begin) => begin > key);
    const [begin, end] = [this.sides[next - 1], this.sides[next]];
    const width = Math.min(5, end - begin);
    const first = Math.min(Math.max(key - (width >> 1), begin), end - width);
    const unit = (this.end - this.start) / (this.times.length - 1);
    const nodes = Array.from({ length: width }, (_, k) => (this.times[first + k] - this.times[key]) / unit);
    const product = (numbers) => numbers.reduce((total, number) => total * number, 1);
    const weights = nodes.map((node, k) => {
      const others = nodes.filter((_, j) => j !== k);
      const terms = others.map((_, left) => product(others.filter((_, i) => i !== left).map((other) => -other)));
      return terms.reduce((sum, term) => sum + term, 0) / product(others.map((other) => node - other)) / unit;
    });
    return { first: first, weights: weights };
  }

  // The pose of a body: on its path, or linear in the coordinates.
  pose(body, number, coordinates, time) {
    if (this.paths[number]) return this.poseOnPath(number, time);
    const sum = (start, terms) => {
      const total = start.slice();
      for (const [i, ...perUnit] of terms) {
        for (let axis = 0; axis < 3; axis++) total[axis] += coordinates[i] * perUnit[axis];
      }
      return total;
    };
    const turn = sum([0, 0, 0], body.turns);
    const quaternion = quaternionOf(turn).multiply(quaternionOf(body.rest_turn)).toArray();
    return { position: sum(body.rest, body.moves), quaternion: quaternion, turn: turn };
  }
}

// Of a rotation vector.
function quaternionOf(turn) {
  const angle = Math.hypot(...turn);
  const share = angle > 0 ? Math.sin(angle / 2) / angle : 0.5;
  return new THREE.Quaternion(...turn.map((value) => share * value), Math.cos(angle / 2));
}
