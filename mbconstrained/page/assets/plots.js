// Plots: cursors at the current time, values of the curves next to their names at the time of the pointer or else of the
// cursor, and names that show and hide their curves. On a page with an animation plots.seek(time) is called by a press or
// a drag in a plot, and plots.read(coordinate, time) gives the value of a coordinate.
const cells = 10000; // of the square in which curves are written, as wide and as high as the axes
const plots = { all: [], seek: null, read: null, time: null, hover: null };
const svgNamespace = "http://www.w3.org/2000/svg";

class PlottedCurve {
  constructor(plot, path, entry) {
    this.plot = plot;
    this.path = path;
    this.button = entry.querySelector("button");
    this.value = entry.querySelector(".value");
    this.points = pointsOf(path.getAttribute("d"));
    this.digits = Number(path.dataset.digits); // NaN where none are known
    this.error = "error" in path.dataset ? Number(path.dataset.error) : null; // of the points; between them it is estimated from the curvature
    this.coordinate = "coordinate" in path.dataset ? Number(path.dataset.coordinate) : null;
    this.dot = plot.add("circle", { class: path.getAttribute("class").replace("off", ""), r: 4, visibility: "hidden" });
    this.button.addEventListener("click", () => this.toggle());
    for (const [event, lit] of [["pointerenter", true], ["pointerleave", false], ["focus", true], ["blur", false]]) {
      this.button.addEventListener(event, () => this.light(lit && this.shown));
    }
  }

  get shown() {
    return !this.path.classList.contains("off");
  }

  toggle() {
    const off = this.path.classList.toggle("off");
    this.button.setAttribute("aria-pressed", !off);
    this.light(!off);
    this.plot.show();
  }

  light(lit) {
    this.path.classList.toggle("lit", lit);
    this.plot.svg.classList.toggle("dim", lit);
  }

  // The point at a share of the time of the plot, between its neighbours.
  at(share) {
    const last = this.points.x.length - 1;
    const position = this.along ? place(this.along, share * cells) : share * last;
    const key = Math.min(last - 1, Math.floor(position));
    const between = (numbers) => numbers[key] + (position - key) * (numbers[key + 1] - numbers[key]);
    return [between(this.points.x), between(this.points.y), key];
  }

  get along() {
    return this.plot.even ? null : this.plot.times || this.points.x;
  }

  // How far a point lies above the line through its neighbours, in cells.
  bend(key) {
    const y = this.points.y;
    if (key <= 0 || key >= y.length - 1) return 0;
    const [before, here, after] = [key - 1, key, key + 1].map((i) => (this.along ? this.along[i] : i));
    const part = after > before ? (here - before) / (after - before) : 0.5;
    return y[key] - y[key - 1] - part * (y[key + 1] - y[key - 1]);
  }

  // Error in cells of a value after a point: of a smooth curve a quarter of the bend; at a jump the bends are opposite.
  errorAfter(key) {
    const [one, other] = [this.bend(key), this.bend(key + 1)];
    const bent = one * other < 0 ? Math.abs(one - other) : Math.max(Math.abs(one), Math.abs(other)) / 2;
    return this.error + bent;
  }

  show(time) {
    const share = this.plot.share(time);
    const there = share !== null && this.shown;
    this.dot.setAttribute("visibility", there ? "visible" : "hidden");
    this.value.textContent = there ? this.read(share, time) : "";
  }

  // The value with its known digits: of a coordinate from the motion itself, of any other curve from its drawn points.
  read(share, time) {
    const { across, up, phase, height } = this.plot;
    const [x, y, key] = this.at(share);
    const read = this.coordinate !== null && plots.read;
    const upwards = read ? up.share(plots.read(this.coordinate, time)) : 1 - y / cells;
    this.dot.setAttribute("cx", `${(100 * x) / cells}%`);
    this.dot.setAttribute("cy", height * (1 - upwards));
    const digits = this.error === null ? this.digits : up.digitsFor(this.errorAfter(key));
    const texts = [...(phase ? [across.text(x / cells)] : []), up.text(upwards, digits)];
    return texts.every(Boolean) ? texts.join(", ") : "";
  }
}

class PlottedFigure {
  constructor(svg) {
    this.svg = svg;
    this.height = svg.clientHeight || 214;
    this.start = Number(svg.dataset.start);
    this.end = Number(svg.dataset.end);
    this.phase = "times" in svg.dataset;
    this.times = svg.dataset.times ? sums(svg.dataset.times.split(" ").map(Number)) : null;
    this.even = "even" in svg.dataset || svg.dataset.times === "";
    this.across = new Scale(svg.dataset.across, svg.dataset.acrossUnit, Number(svg.dataset.acrossDigits));
    this.up = new Scale(svg.dataset.up, svg.dataset.upUnit);
    this.cursor = this.add("line", { class: "cursor", y2: this.height, visibility: "hidden" });
    this.pointer = this.add("line", { class: "pointer", y2: this.height, visibility: "hidden" });
    this.pointerTime = this.add("text", { class: "pointer-time", y: -3, "text-anchor": "middle" });
    const entries = svg.closest("figure").querySelectorAll(".legend li");
    this.curves = [...svg.querySelectorAll("path")].map((path, i) => new PlottedCurve(this, path, entries[i]));
    svg.addEventListener("pointerdown", (event) => this.press(event));
    svg.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerleave", "pointercancel"]) svg.addEventListener(end, () => hover(null));
  }

  add(tag, attributes) {
    const element = document.createElementNS(svgNamespace, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    this.svg.append(element);
    return element;
  }

  // Values are those at the pointer, or else at the current time.
  show() {
    const [time, pointed] = [this.share(plots.time), this.share(plots.hover)];
    this.curves.forEach((curve) => curve.show(plots.hover === null ? plots.time : plots.hover));
    if (this.phase) return;
    this.put(this.cursor, time);
    this.put(this.pointer, pointed);
    this.pointerTime.textContent = pointed === null ? "" : this.across.text(pointed);
    this.pointerTime.setAttribute("x", `${100 * pointed}%`);
  }

  // The part of the plot's time that has passed, or null where it has no such time.
  share(time) {
    const share = time === null ? NaN : (time - this.start) / (this.end - this.start);
    return share >= 0 && share <= 1 ? share : null;
  }

  put(line, share) {
    line.setAttribute("visibility", share === null ? "hidden" : "visible");
    for (const end of ["x1", "x2"]) line.setAttribute(end, `${(100 * share).toFixed(3)}%`);
  }

  timeAt(event) {
    const box = this.svg.getBoundingClientRect();
    const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    const share = this.phase ? this.nearest(x, y, box) : Math.min(1, Math.max(0, x));
    return this.start + share * (this.end - this.start);
  }

  // The part of the time at which a phase curve is nearest to the pointer; where it crosses itself, the one nearest to now.
  nearest(x, y, box) {
    const { points } = this.curves[0];
    const distances = points.x.map((px, i) => Math.hypot((px / cells - x) * box.width, (points.y[i] / cells - y) * box.height));
    const closest = Math.min(...distances);
    const shareAt = (i) => (this.times ? this.times[i] / cells : i / (distances.length - 1));
    const now = this.share(plots.time) || 0;
    const shares = distances.flatMap((distance, i) => (distance < closest + 5 ? [shareAt(i)] : []));
    return shares.reduce((best, share) => (Math.abs(share - now) < Math.abs(best - now) ? share : best));
  }

  press(event) {
    if (event.button !== 0) return;
    this.svg.setPointerCapture(event.pointerId);
    if (plots.seek) plots.seek(this.timeAt(event));
    hover(this.timeAt(event));
  }

  move(event) {
    const time = this.timeAt(event);
    if (plots.seek && event.buttons === 1 && this.svg.hasPointerCapture(event.pointerId)) plots.seek(time);
    hover(time);
  }
}

// An axis: its ends in the unit of its labels, the power of ten of that unit, the unit, and the number of known digits.
class Scale {
  constructor(ends, unit, digits) {
    [this.low, this.high, this.exponent] = ends.split(" ").map(Number);
    this.unit = unit;
    this.digits = digits;
  }

  share(value) {
    return (value / 10 ** this.exponent - this.low) / (this.high - this.low);
  }

  // Digits after the decimal point of numbers with an error in cells; NaN where not even the first is known.
  digitsFor(error) {
    const cell = (this.high - this.low) / cells;
    const digits = Math.min(12, Math.floor(1e-9 - Math.log10(Math.max(cell, 2 * error * cell))));
    return 10 ** -digits > this.high - this.low ? NaN : digits;
  }

  // With digits below zero tens or hundreds, as in "≈ 300"; all other zeros at the end are known digits.
  text(share, digits = this.digits) {
    if (Number.isNaN(digits)) return "";
    const value = this.low + share * (this.high - this.low);
    const number = digits < 0 ? String(Math.round(value * 10 ** digits) * 10 ** -digits) : value.toFixed(digits);
    if (digits < 0 && Number(number) === 0) return ""; // it is smaller than its error
    const signed = number.replace(/^-(?=[0.]*$)/, "").replace("-", "−");
    return `${digits < 0 ? "≈ " : ""}${signed} ${this.unit}`.trim();
  }
}

// "M0 5l1 2 3-4": the first point, then the steps from point to point.
function pointsOf(data) {
  const numbers = data.match(/-?\d+/g).map(Number);
  return { x: sums(numbers.filter((_, i) => i % 2 === 0)), y: sums(numbers.filter((_, i) => i % 2 === 1)) };
}

function sums(numbers) {
  let total = 0;
  return numbers.map((number) => (total += number));
}

// The position of a number in an ascending list: 2.5 is in the middle between the third entry and the fourth.
function place(list, number) {
  let [low, high] = [0, list.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= number) low = middle;
    else high = middle;
  }
  return low + Math.min(1, Math.max(0, (number - list[low]) / (list[high] - list[low] || 1)));
}

function hover(time) {
  plots.hover = time;
  plots.all.forEach((plot) => plot.show());
}

function showInPlots(time) {
  plots.time = time;
  plots.all.forEach((plot) => plot.show());
}

for (const svg of document.querySelectorAll("svg.plot")) {
  if (svg.querySelector("path")) plots.all.push(new PlottedFigure(svg));
}
