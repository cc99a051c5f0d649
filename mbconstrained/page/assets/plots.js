// Plots: cursors at the current time, values of the curves next to their names at the time of the pointer or else of the
// cursor, names that show and hide their curves, and parts of the axes. On a page with an animation plots.seek(time) is called by
// a press in a plot, and by a drag where the whole is shown; plots.pointed(time) while the pointer is over one, and with null after.
// Their cursor is of plots.variable, which is the frequency on the page of a response. Between two computed points of a curve there is
// no value: the pointer takes the nearest one. What a mark or a cell of a map stands for is read next to the pointer.
const cells = 10000; // of the square in which curves are written, as wide and as high as the axes
const near = 14; // px from a curve to the pointer that highlights it
const pressed = 4; // px that the pointer moves at most in a press
const [atEdge, nearEnd] = [1e-9, 0.9]; // shares of an axis: of a point at its end, and from which there is no room for a name
const tableRows = 2001; // of a table of functions
const scrolling = 400; // ms after the wheel has scrolled the page in which it goes on scrolling
const plots = { all: [], sets: [], phases: null, seek: null, pointed: null, variable: "time", time: null, hover: null, over: null, scrolled: -Infinity };
const svgNamespace = "http://www.w3.org/2000/svg";

class PlottedCurve {
  constructor(plot, entry, number, path) {
    this.plot = plot;
    this.path = path;
    this.original = path && path.getAttribute("d");
    this.entry = entry;
    this.button = entry.querySelector("button");
    this.value = entry.querySelector(".value");
    const places = entry.dataset.function.split(" ").map(Number);
    this.functions = plots.sets[places[places.length - 2]];
    this.row = places[places.length - 1];
    this.across = plot.phase ? { functions: plots.sets[places[0]], row: places[1] } : null;
    this.parts = rangesOf(entry.dataset.parts, [plot.start, plot.end]);
    this.look = entry.querySelector("path").getAttribute("class");
    this.dot = plot.add("circle", { class: this.look, r: 4, visibility: "hidden" });
    this.button.addEventListener("click", () => this.toggle());
    this.button.addEventListener("dblclick", () => this.plot.showOnly(this));
    for (const [event, lit] of [["pointerenter", true], ["pointerleave", false], ["focus", true], ["blur", false]]) {
      this.button.addEventListener(event, () => this.plot.light(lit && this.shown ? this : null));
    }
  }

  get shown() {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  set shown(shown) {
    this.button.setAttribute("aria-pressed", shown);
    if (shown) this.draw();
    if (this.path) this.path.classList.toggle("off", !shown);
    this.plot.placeMarks();
  }

  toggle() {
    this.shown = !this.shown;
    this.plot.light(this.shown ? this : null);
    this.plot.show();
  }

  // The whole curve as it was written, or the part of it that is shown, from the functions.
  draw() {
    if (!this.path) {
      this.path = document.createElementNS(svgNamespace, "path");
      this.path.setAttribute("class", this.look);
      this.plot.paths.append(this.path);
    }
    const part = this.original && !this.plot.zoomed ? this.original : this.outline();
    if (this.path.getAttribute("d") !== part) this.path.setAttribute("d", part);
  }

  // Times of the part that is shown at which a table has the curve; of a function as many as there is room for, evenly along the axis.
  timesShown() {
    const { across, phase, start, end } = this.plot;
    const { samples } = this.functions;
    const at = (share) => (phase ? start + (end - start) * share : across.value(share));
    const [from, to] = phase ? [start, end] : across.ends;
    const times = samples ? samples.points(from, to) : Array.from({ length: tableRows }, (_, i) => at(i / (tableRows - 1)));
    return [...new Set(times.map((time) => Math.min(end, Math.max(start, time))))].filter((time) => this.has(time));
  }

  outline() {
    const { across, svg, phase, start, end } = this.plot;
    const width = svg.clientWidth || 600;
    const [from, to] = phase ? [start, end] : across.ends.map((time) => Math.min(end, Math.max(start, time)));
    const spacing = phase ? (to - from) / Math.min(20000, 2000 / (across.view[1] - across.view[0])) : (to - from) / width;
    const shown = this.parts.map(([begin, stop]) => [Math.max(from, begin), Math.min(to, stop)]).filter(([begin, stop]) => begin <= stop);
    return shown.map(([begin, stop]) => {
      const points = this.functions.timesBetween(begin, stop, spacing).map((time) => this.point(time));
      const drawn = points.map(([x, y]) => [cells * x, cells * (1 - y)]);
      const kept = phase ? drawn : thinned(drawn, cells / width);
      return "M" + kept.map(([a, b]) => `${Math.round(10 * a) / 10} ${Math.round(10 * clipped(b)) / 10}`).join("L");
    }).join("");
  }

  has(time) {
    return this.parts.some(([begin, end]) => time >= begin && time <= end);
  }

  at(time) {
    return this.functions.at(this.row, time);
  }

  show(time) {
    const there = time !== null && this.shown && this.has(time);
    const point = there ? this.point(time) : [NaN, NaN];
    const inside = point.every((share) => share >= 0 && share <= 1);
    this.dot.setAttribute("visibility", there && inside ? "visible" : "hidden");
    if (inside) {
      this.dot.setAttribute("cx", `${(100 * point[0]).toFixed(3)}%`);
      this.dot.setAttribute("cy", (this.plot.height * (1 - point[1])).toFixed(2));
    }
    this.value.textContent = there ? this.text(time) : "";
  }

  point(time) {
    const { across, up, phase } = this.plot;
    return [across.share(phase ? this.across.functions.at(this.across.row, time)[0] : time), up.share(this.at(time)[0])];
  }

  text(time) {
    const { across, up, phase } = this.plot;
    const texts = phase ? [readingText(...this.across.functions.at(this.across.row, time), across.unit, across.exponent)] : [];
    return [...texts, readingText(...this.at(time), up.unit, up.exponent)].join(", ");
  }
}

class PlottedFigure {
  constructor(svg) {
    this.svg = svg;
    this.figure = svg.closest("figure");
    this.height = svg.clientHeight || 214;
    this.start = Number(svg.dataset.start);
    this.end = Number(svg.dataset.end);
    this.phase = svg.dataset.over === "phase";
    this.over = this.phase ? svg.dataset.variable || "time" : svg.dataset.over;
    this.across = new Axis(svg.dataset.across, svg.dataset.acrossUnit);
    this.up = new Axis(svg.dataset.up, svg.dataset.upUnit);
    this.ticks = svg.querySelector(".ticks");
    this.paths = svg.querySelector(".curves");
    this.guides = svg.querySelector(".guides");
    this.phases = svg.querySelector(".phases");
    this.phaseNames = [...this.figure.querySelectorAll("[data-phase]")];
    this.marks = [...svg.querySelectorAll(".mark")];
    this.notes = new Map([...svg.querySelectorAll("title")].map((title) => [title.parentNode.closest(".mark, rect"), title.textContent]));
    this.notes.delete(null); // that of a phase remains
    this.notes.forEach((_, part) => part.querySelector("title").remove()); // it is shown sooner, and by a touch, too
    this.left = svg.style.getPropertyValue("--left");
    this.grid = this.ticks.innerHTML;
    this.pointers = new Map();
    this.cursor = this.add("line", { class: "cursor", y2: this.height, visibility: "hidden" });
    this.pointer = this.add("line", { class: "pointer", y2: this.height, visibility: "hidden" });
    this.pointerTime = this.add("text", { class: "pointer-time", y: -3, "text-anchor": "middle" });
    const entries = [...this.figure.querySelectorAll(".legend [data-function]")];
    const pathOf = (number) => this.paths.querySelector(`[data-number="${number}"]`);
    this.curves = entries.map((entry, i) => new PlottedCurve(this, entry, i, pathOf(i)));
    this.samples = [...new Set(this.curves.flatMap((curve) => [curve, curve.across]).filter(Boolean).map(({ functions }) => functions.samples).filter(Boolean))];
    this.reset = this.button("whole", "Show the whole", () => this.showWhole());
    this.reset.hidden = true;
    this.button("csv", "CSV", () => this.save()).title = "save what is drawn as a table";
    this.reading = document.createElement("p");
    Object.assign(this.reading, { className: "reading", hidden: true });
    this.reading.setAttribute("role", "status");
    this.figure.append(this.reading);
    this.listen();
    this.choose();
  }

  get zoomed() {
    return this.across.zoomed || this.up.zoomed;
  }

  // Whether a press moves the cursor of the page.
  get seeks() {
    return plots.seek !== null && this.over === plots.variable;
  }

  add(tag, attributes, parent = this.svg) {
    const element = document.createElementNS(svgNamespace, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    parent.append(element);
    return element;
  }

  button(name, text, act) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", className: name, textContent: text });
    button.addEventListener("click", act);
    this.figure.prepend(button);
    return button;
  }

  listen() {
    const { svg } = this;
    svg.addEventListener("pointerdown", (event) => this.press(event));
    svg.addEventListener("pointermove", (event) => this.move(event));
    svg.addEventListener("pointerup", (event) => this.release(event));
    for (const end of ["pointerleave", "pointercancel"]) {
      svg.addEventListener(end, (event) => {
        this.pointers.delete(event.pointerId);
        this.light(null);
        const stays = event.pointerType === "touch" && end === "pointerleave"; // a finger that is lifted leaves what it has pointed at
        if (!stays) this.read(null);
        if (!stays || this.seeks) hover(null);
      });
    }
    svg.addEventListener("dblclick", () => this.showWhole());
    svg.addEventListener("wheel", (event) => this.turn(event), { passive: false });
    svg.addEventListener("keydown", (event) => this.key(event));
  }

  // The names of many curves can be searched, and all found ones shown or hidden.
  choose() {
    const search = this.figure.querySelector(".choice input");
    if (!search) return;
    const found = () => this.curves.filter((curve) => !curve.entry.hidden);
    search.addEventListener("input", () => {
      const text = search.value.toLowerCase();
      this.curves.forEach((curve) => (curve.entry.hidden = !curve.button.textContent.toLowerCase().includes(text)));
    });
    for (const button of this.figure.querySelectorAll("[data-choice]")) {
      button.addEventListener("click", () => {
        found().forEach((curve) => (curve.shown = button.dataset.choice === "all"));
        this.show();
      });
    }
  }

  showOnly(only) {
    this.curves.forEach((curve) => (curve.shown = curve === only));
    this.show();
  }

  // Highlights a curve and brings it to the front; null for none.
  light(lit) {
    if (this.lit === lit) return;
    this.lit = lit;
    this.svg.classList.toggle("dim", lit !== null);
    for (const curve of this.curves) {
      curve.entry.classList.toggle("lit", curve === lit);
      if (curve.path) curve.path.classList.toggle("lit", curve === lit);
    }
    if (lit && lit.path) this.paths.append(lit.path);
    else this.sort();
  }

  // The smallest curve is drawn last, as on the whole page.
  sort() {
    const drawn = this.curves.filter((curve) => curve.path);
    drawn.forEach((curve) => (curve.span = curve.span || spanOf(curve)));
    drawn.sort((one, other) => other.span - one.span).forEach((curve) => this.paths.append(curve.path));
  }

  // Values are those at the pointer, or else at the current time.
  show() {
    const now = this.over === plots.variable ? this.within(plots.time) : null;
    const pointed = plots.over === this.over ? this.within(plots.hover) : null;
    this.curves.forEach((curve) => curve.show(pointed === null ? now : pointed));
    const phase = phaseAt(pointed === null ? now : pointed);
    this.phaseNames.forEach((entry) => entry.classList.toggle("lit", entry.dataset.phase === phase));
    if (this.phase) {
      const [at, { variable, variableUnit }] = [pointed === null ? now : pointed, this.svg.dataset];
      const named = at !== null && variableUnit !== undefined;
      this.pointerTime.textContent = named ? `${variable}: ${numberWithUnit(Number(at.toPrecision(4)), variableUnit)}` : "";
      this.pointerTime.setAttribute("x", "50%");
      return;
    }
    this.put(this.cursor, now);
    this.put(this.pointer, pointed);
    const rounded = pointed !== null && this.across.rounded(pointed, 2 * this.svg.clientWidth);
    this.pointerTime.textContent = rounded ? this.across.text(pointed, rounded.digits) : "";
    this.pointerTime.setAttribute("x", `${100 * (rounded ? this.across.share(pointed) : 0)}%`);
  }

  // A time that the plot has, or null.
  within(time) {
    return time !== null && time >= this.start && time <= this.end ? time : null;
  }

  put(line, time) {
    const share = time === null ? -1 : this.across.share(time);
    line.setAttribute("visibility", share >= 0 && share <= 1 ? "visible" : "hidden");
    for (const end of ["x1", "x2"]) line.setAttribute(end, `${(100 * share).toFixed(3)}%`);
  }

  // Where a pointer is, as shares of the axes, from the left and from below.
  shares(event) {
    const box = this.svg.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height];
  }

  timeAt(event) {
    const [x, y] = this.shares(event);
    if (this.phase) return this.nearest(x, y);
    const time = this.across.value(Math.min(1, Math.max(0, x)));
    const computed = this.computed(time);
    return computed === null ? Math.min(this.end, Math.max(this.start, this.across.rounded(time, 2 * this.svg.clientWidth).value)) : computed;
  }

  // The nearest of the computed points; null where all curves are functions, or are constant to the next point.
  computed(time) {
    if (!this.samples.length) return null;
    let [best, least] = [null, Infinity];
    for (const functions of this.samples) {
      for (const at of functions.around(time)) {
        const distance = Math.abs(this.across.share(at) - this.across.share(time));
        if (distance < least) [best, least] = [at, distance];
      }
    }
    return best;
  }

  // What the nearest mark within reach, or else the cell at the pointer, stands for.
  read(event) {
    const place = event && this.noteAt(event);
    this.marks.forEach((mark) => mark.classList.toggle("lit", mark === place));
    this.reading.hidden = !place;
    if (!place) return;
    this.reading.textContent = this.notes.get(place);
    const box = this.figure.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const free = box.width - this.reading.offsetWidth - 4;
    this.reading.style.left = `${Math.min(Math.max(4, x - this.reading.offsetWidth / 2), free)}px`;
    this.reading.style.top = `${y - this.reading.offsetHeight - 14}px`;
  }

  noteAt(event) {
    const box = this.svg.getBoundingClientRect();
    let [best, least] = [null, near];
    for (const mark of this.marks) {
      if (!this.notes.has(mark) || mark.getAttribute("visibility") === "hidden") continue;
      const [x, y] = [(box.width * parseFloat(mark.getAttribute("x"))) / 100, Number(mark.getAttribute("y"))];
      const distance = Math.hypot(event.clientX - box.left - x, event.clientY - box.top - y);
      if (distance < least) [best, least] = [mark, distance];
    }
    if (best) return best;
    return document.elementsFromPoint(event.clientX, event.clientY).find((part) => this.notes.has(part) && part.localName === "rect") || null;
  }

  // The time at which a shown phase curve is nearest to the pointer; where it crosses itself, the one nearest to now.
  nearest(x, y) {
    const box = this.svg.getBoundingClientRect();
    const points = this.curves.filter((curve) => curve.shown).flatMap((curve) => {
      const times = curve.functions.timesBetween(this.start, this.end, (this.end - this.start) / 2000);
      return times.filter((time) => curve.has(time)).map((time) => {
        const [px, py] = curve.point(time);
        return [time, Math.hypot((px - x) * box.width, (py - y) * box.height)];
      });
    });
    const closest = points.reduce((least, [, distance]) => Math.min(least, distance), Infinity);
    const now = this.within(plots.time) === null ? this.start : plots.time;
    const near = points.filter(([, distance]) => distance < closest + 5).map(([time]) => time);
    return near.reduce((best, time) => (Math.abs(time - now) < Math.abs(best - now) ? time : best), near.length ? near[0] : this.start);
  }

  // The shown curve that is nearest to the pointer, or null.
  curveAt(event) {
    const [x, y] = this.shares(event);
    const time = this.timeAt(event);
    const { width } = this.svg.getBoundingClientRect();
    const distances = this.curves.map((curve) => {
      if (!curve.shown || !curve.has(time)) return Infinity;
      const [px, py] = curve.point(time);
      return Math.hypot(this.phase ? (px - x) * width : 0, (py - y) * this.height);
    });
    const least = Math.min(...distances);
    return least < near ? this.curves[distances.indexOf(least)] : null;
  }

  press(event) {
    if (event.button !== 0) return;
    this.svg.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, startX: event.clientX, startY: event.clientY, moved: false });
    plots.all.forEach((plot) => plot.read(plot === this && this.pointers.size === 1 ? event : null));
    if (this.pointers.size > 1) return;
    if (this.seeks && !this.zoomed) plots.seek(this.timeAt(event));
    hover(this.timeAt(event), this.over);
  }

  move(event) {
    const held = this.pointers.get(event.pointerId);
    this.read(held && (this.pointers.size === 2 || this.zoomed) ? null : event);
    if (!held) {
      this.light(this.curveAt(event));
      hover(this.timeAt(event), this.over);
      return;
    }
    const box = this.svg.getBoundingClientRect();
    held.moved = held.moved || Math.hypot(event.clientX - held.startX, event.clientY - held.startY) > pressed;
    if (this.pointers.size === 2) {
      this.pinch(event, held, box);
    } else if (this.zoomed) {
      if (held.moved) this.pan((held.x - event.clientX) / box.width, (event.clientY - held.y) / box.height);
      hover(this.timeAt(event), this.over);
    } else {
      if (this.seeks) plots.seek(this.timeAt(event));
      hover(this.timeAt(event), this.over);
    }
    Object.assign(held, { x: event.clientX, y: event.clientY });
  }

  // Two fingers: the part that is shown follows their distance and their middle.
  pinch(event, held, box) {
    const [other] = [...this.pointers.entries()].filter(([id]) => id !== event.pointerId).map(([, pointer]) => pointer);
    const before = Math.hypot(held.x - other.x, held.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    const middle = { clientX: (event.clientX + other.x) / 2, clientY: (event.clientY + other.y) / 2 };
    other.moved = held.moved = true;
    this.pan((held.x - event.clientX) / 2 / box.width, (event.clientY - held.y) / 2 / box.height);
    if (before > 0) this.zoom(after / before, ...this.shares(middle));
  }

  release(event) {
    const held = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (held && !held.moved && this.zoomed && this.seeks) plots.seek(this.timeAt(event));
  }

  // The wheel zooms at the pointer: over the labels along their axis only. A page that is being scrolled goes on scrolling, and so it
  // does where the whole is shown and would become smaller.
  turn(event) {
    const turned = event.deltaY || event.deltaX; // with Shift some systems turn the wheel sideways
    const factor = Math.exp(-0.002 * turned * (event.deltaMode === 1 ? 16 : 1));
    if ((factor < 1 && !this.zoomed) || (!event.ctrlKey && performance.now() - plots.scrolled < scrolling)) return;
    event.preventDefault();
    const [x, y] = this.shares(event);
    this.zoom(factor, x, y, x >= 0 && !event.altKey, y >= 0 && !event.shiftKey);
    hover(this.timeAt(event), this.over);
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const act = {
      "+": () => this.zoom(1.5, 0.5, 0.5),
      "=": () => this.zoom(1.5, 0.5, 0.5),
      "-": () => this.zoom(1 / 1.5, 0.5, 0.5),
      0: () => this.showWhole(),
      ArrowLeft: () => this.pan(-0.1, 0),
      ArrowRight: () => this.pan(0.1, 0),
      ArrowUp: () => this.pan(0, 0.1),
      ArrowDown: () => this.pan(0, -0.1),
    }[event.key];
    if (!act || (event.key.startsWith("Arrow") && !this.zoomed)) return;
    event.preventDefault();
    event.stopPropagation(); // the animation has keys, too
    act();
  }

  zoom(factor, x, y, along = true, upwards = true) {
    if (along) this.across.zoom(factor, Math.min(1, Math.max(0, x)));
    if (upwards) this.up.zoom(factor, Math.min(1, Math.max(0, y)));
    this.redraw();
  }

  pan(along, upwards) {
    this.across.pan(along);
    this.up.pan(upwards);
    this.redraw();
  }

  showWhole() {
    this.across.reset();
    this.up.reset();
    this.redraw();
  }

  // Axes and curves of the part that is shown, once for each picture of the screen.
  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.svg.classList.toggle("zoomed", this.zoomed);
      this.reset.hidden = !this.zoomed;
      if (this.zoomed) this.drawTicks();
      else this.ticks.innerHTML = this.grid;
      if (!this.zoomed) this.svg.style.setProperty("--left", this.left);
      if (this.phases) this.phases.setAttribute("viewBox", [cells * this.across.view[0], 0, cells * (this.across.view[1] - this.across.view[0]), 3].join(" "));
      if (this.guides) this.guides.setAttribute("viewBox", this.part());
      this.placeMarks();
      this.curves.filter((curve) => curve.shown).forEach((curve) => curve.draw());
      this.show();
    });
  }

  // The part that is shown of the square in which the guides are written.
  part() {
    const [[left, right], [low, high]] = [this.across.view, this.up.view];
    return [left, 1 - high, right - left, high - low].map((share) => cells * share).join(" ");
  }

  // Marks in the part that is shown, of shown curves.
  placeMarks() {
    for (const mark of this.marks) {
      const [x, y] = mark.dataset.at.split(" ").map((value, i) => [this.across, this.up][i].share(Number(value)));
      const curve = mark.dataset.curve === undefined ? null : this.curves[mark.dataset.curve];
      const inside = [x, y].every((share) => share >= -1e-9 && share <= 1 + 1e-9);
      mark.setAttribute("visibility", inside && (curve === null || curve.shown) ? "visible" : "hidden");
      mark.setAttribute("x", `${(100 * x).toFixed(3)}%`);
      mark.setAttribute("y", (this.height * (1 - y)).toFixed(2));
    }
  }

  // Saves the curves and marks that are drawn, in the part that is shown, as a table.
  save() {
    saveFile([tableText(this.table())], "text/csv", `${document.title} ${this.figure.querySelector("h2").textContent}`, "csv");
  }

  // Columns: the variable, every shown curve with its marks, and what the marks stand for.
  table() {
    const { across, up, phase, svg } = this;
    const { name, variableUnit } = svg.dataset;
    const headed = (text, unit) => (unit ? `${text} (${unit})` : text);
    const shown = this.curves.filter((curve) => curve.shown);
    const marks = this.marks.filter((mark) => mark.getAttribute("visibility") !== "hidden");
    const values = (mark) => mark.dataset.at.split(" ").map(Number);
    if (up.rows) return this.tableOfRows(shown, marks, headed(name, across.unit), values);
    if (this.guides && this.guides.dataset.cells) {
      const rows = [...this.guides.querySelectorAll("rect[data-at]")].map(values);
      const heads = [headed(name, across.unit), headed(svg.dataset.upName, up.unit), headed("value", this.guides.dataset.unit)];
      return heads.map((head, i) => [head, rows.map((row) => row[i])]);
    }
    const noted = marks.filter((mark) => this.notes.has(mark));
    const times = [...new Set(shown.flatMap((curve) => curve.timesShown()))].sort((one, other) => one - other);
    const column = (curve, read, part) => [
      ...times.map((time) => (curve && curve.has(time) ? digitsOf(...read(time)) : "")),
      ...noted.map((mark) => (this.curves[mark.dataset.curve] === curve ? values(mark)[part] : "")),
    ];
    const variable = phase ? headed(this.over, variableUnit ?? (this.over === "time" ? "s" : "")) : headed(name, across.unit);
    const columns = [[variable, [...times.map((time) => Number(time.toPrecision(12))), ...noted.map((mark) => (phase ? "" : values(mark)[0]))]]];
    for (const curve of [...shown, ...(noted.some((mark) => mark.dataset.curve === undefined) ? [undefined] : [])]) {
      const own = curve ? curve.button.textContent : "mark";
      if (phase) columns.push([headed(`${own}: ${name}`, across.unit), column(curve, (time) => curve.across.functions.at(curve.across.row, time), 0)]);
      columns.push([headed(own, up.unit), column(curve, (time) => curve.at(time), 1)]);
    }
    if (noted.length) columns.push(["note", [...times.map(() => ""), ...noted.map((mark) => this.notes.get(mark))]]);
    return columns;
  }

  // A row for each name, with the values of its marks.
  tableOfRows(shown, marks, head, values) {
    const names = new Map(marks.filter((mark) => !this.notes.has(mark)).map((mark) => [values(mark)[1], mark.textContent]));
    const at = (curve, row) => marks.filter((mark) => this.curves[mark.dataset.curve] === curve && values(mark)[1] === row).map((mark) => values(mark)[0])[0];
    return [[this.svg.dataset.upName, [...names.values()]], ...shown.map((curve) => [`${curve.button.textContent}: ${head}`, [...names.keys()].map((row) => at(curve, row))])];
  }

  drawTicks() {
    const { ticks, height } = this;
    ticks.textContent = "";
    const upwards = this.up.ticks();
    const letters = Math.max(0, ...upwards.map(([, text]) => text.length));
    this.svg.style.setProperty("--left", letters > marginLetters ? `max(${this.left || "0px"}, ${Math.round(margin + letter * (letters - marginLetters))}px)` : this.left);
    const along = this.across.ticks();
    const labelled = this.across.labelled(along, this.svg.clientWidth);
    for (const tick of along) {
      const x = `${(100 * this.across.share(tick[0])).toFixed(2)}%`;
      this.add("line", { class: "grid", x1: x, x2: x, y2: height }, ticks);
      const end = this.across.share(tick[0]) > 0.98 && tick[1].length > 4 ? { dx: 14, "text-anchor": "end" } : { "text-anchor": "middle" };
      if (labelled.includes(tick)) this.add("text", { x: x, y: height + 18, ...end }, ticks).textContent = tick[1];
    }
    for (const [value, text] of upwards) {
      const y = (height * (1 - this.up.share(value))).toFixed(1);
      this.add("line", { class: value === 0 ? "axis" : "grid", x2: "100%", y1: y, y2: y }, ticks);
      this.add("text", { x: -8, y: Number(y) + 4, "text-anchor": "end" }, ticks).textContent = text;
    }
    this.add("line", { class: "axis", y2: height }, ticks);
    this.add("line", { class: "axis", x2: "100%", y1: height, y2: height }, ticks);
    for (const line of this.guides ? this.guides.querySelectorAll("[data-name]") : []) this.nameGuide(line);
  }

  // The name of a line next to the end of its part that is shown, as in plots.py.
  nameGuide(line) {
    const views = [this.across.view, this.up.view];
    const [a, b, c, d] = line.getAttribute("d").match(/-?\d+/g).map((text) => text / cells);
    const [from, to] = [[a, 1 - b], [c, 1 - d]].map((point) => point.map((value, k) => (value - views[k][0]) / (views[k][1] - views[k][0])));
    const step = to.map((value, k) => value - from[k]);
    if (step.some((value, k) => value === 0 && Math.abs(from[k] - 0.5) > 0.5)) return;
    const hits = step.map((value, k) => (value === 0 ? [0, 1] : [-from[k] / value, (1 - from[k]) / value].sort((one, other) => one - other)));
    const [begin, end] = [Math.max(0, hits[0][0], hits[1][0]), Math.min(1, hits[0][1], hits[1][1])];
    if (end <= begin) return;
    const [start, [x, y]] = [begin, end].map((part) => from.map((value, k) => value + part * step[k]));
    const [left, right, top] = [x < atEdge, x > 1 - atEdge, y > 1 - atEdge];
    const starts = left || (top && start[0] < x && x < nearEnd);
    const down = this.height * (1 - y) + (step[1] > 0 && (left || right) && y < nearEnd ? -4 : 11);
    const place = { x: `${(100 * x).toFixed(2)}%`, y: Math.min(down, this.height - 3).toFixed(1), dx: starts ? 4 : -4, "text-anchor": starts ? "start" : "end" };
    this.add("text", { class: "guide-name", ...place }, this.ticks).textContent = line.dataset.name;
  }
}

// Columns with their heads as the text of a file; a comma in a name is replaced, as in the files of the commands.
function tableText(columns) {
  const cell = (text) => String(text).replaceAll(",", ";").replace(/\s+/g, " ");
  const rows = columns[0][1].map((_, i) => columns.map(([, values]) => cell(values[i] ?? "")));
  return [columns.map(([head]) => cell(head)), ...rows].map((row) => row.join(",") + "\n").join("");
}

// A number with the digits that its error leaves, at most twelve.
function digitsOf(value, error) {
  const digits = Math.floor(Math.log10(Math.abs(value) / (2 * error)));
  return value === 0 || digits < 0 ? "0" : String(Number(value.toPrecision(Math.min(12, Math.max(1, digits)))));
}

// Stretches of times from a text of their ends; the whole where there is none.
function rangesOf(text, whole) {
  if (text === undefined) return [whole];
  const ends = text.split(" ").map(Number);
  return Array.from({ length: ends.length / 2 }, (_, i) => [ends[2 * i], ends[2 * i + 1]]);
}

// The height of a curve in its plot, in cells.
function spanOf(curve) {
  const numbers = (curve.original || curve.path.getAttribute("d")).match(/-?[\d.]+/g)?.map(Number) ?? [0, 0];
  let [y, low, high] = [numbers[1], numbers[1], numbers[1]];
  for (let i = 3; i < numbers.length; i += 2) {
    y = curve.original ? y + numbers[i] : numbers[i];
    [low, high] = [Math.min(low, y), Math.max(high, y)];
  }
  return high - low;
}

// Of points from left to right those that are seen: the first, lowest, highest and last of each column.
function thinned(points, column) {
  if (points.length < (4 * cells) / column) return points;
  const kept = [];
  for (let begin = 0; begin < points.length; ) {
    let end = begin;
    const place = Math.floor(points[begin][0] / column);
    while (end < points.length && Math.floor(points[end][0] / column) === place) end++;
    const group = points.slice(begin, end);
    const extreme = (pick) => group.reduce((best, point) => (pick(point[1], best[1]) ? point : best));
    const four = [group[0], extreme((a, b) => a < b), extreme((a, b) => a > b), group[group.length - 1]];
    kept.push(...[...new Set(four)].sort((a, b) => a[0] - b[0]));
    begin = end;
  }
  return kept;
}

// Heights far outside the picture cannot be drawn.
function clipped(height) {
  return Math.min(1e6, Math.max(-1e6, height));
}

function hover(time, over = null) {
  plots.hover = time;
  plots.over = over;
  if (plots.pointed && (time === null || over === plots.variable)) plots.pointed(time);
  plots.all.forEach((plot) => plot.show());
}

function showInPlots(time) {
  plots.time = time;
  plots.all.forEach((plot) => plot.show());
}

// The name of the phase at a time, or null.
function phaseAt(time) {
  if (time === null || !plots.phases) return null;
  const { begins, names } = plots.phases;
  return names[lastBefore(begins, time)];
}

const plotData = JSON.parse(document.getElementById("plot-data").textContent);
plots.sets = functionsOf(plotData);
plots.phases = plotData.phases && { begins: unpack(plotData.phases.begins, Float64Array), names: plotData.phases.names };
for (const svg of document.querySelectorAll("svg.plot")) {
  if (svg.querySelector(".curves")) plots.all.push(new PlottedFigure(svg));
}
document.addEventListener("wheel", (event) => event.defaultPrevented || (plots.scrolled = performance.now()), { passive: true });
