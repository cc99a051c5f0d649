// The motion: each coordinate as a function of time, cubic between the key frames and exact on them.
class Motion {
  constructor(frames) {
    this.times = frames.times;
    this.names = frames.names;
    this.values = frames.values; // per coordinate: its values at the key frames, or one number if it never changes
    this.rates = frames.rates; // per coordinate: its rates at the key frames, or 0
    this.start = this.times[0];
    this.end = this.times[this.times.length - 1];
  }

  clamp(time) {
    return Math.min(this.end, Math.max(this.start, time));
  }

  // The values of all coordinates at a time, in the order of the names.
  at(time) {
    const key = this.keyBefore(time);
    return this.values.map((values, i) =>
      typeof values === "number" ? values : this.between(values, this.rates[i], key, time)
    );
  }

  // Index of the last key frame, but one at most, that is not after the time.
  keyBefore(time) {
    let low = 0;
    let high = this.times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  // Cubic Hermite interpolation.
  between(values, rates, key, time) {
    const length = this.times[key + 1] - this.times[key];
    const s = (time - this.times[key]) / length;
    const r = 1 - s;
    return (
      r * r * (1 + 2 * s) * values[key] +
      s * s * (1 + 2 * r) * values[key + 1] +
      length * s * r * (r * rates[key] - s * rates[key + 1])
    );
  }
}

// Where a body is and how it is turned when the coordinates have these values: both are linear in them.
function poseOf(body, coordinates) {
  const sum = (start, terms) => {
    const total = start.slice();
    for (const [i, ...perUnit] of terms) {
      for (let axis = 0; axis < 3; axis++) total[axis] += coordinates[i] * perUnit[axis];
    }
    return total;
  };
  return { position: sum(body.rest, body.moves), turn: sum(body.rest_turn, body.turns) };
}
