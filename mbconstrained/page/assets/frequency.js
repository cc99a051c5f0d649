// The page of a frequency response: one cycle of the motion at the frequency of the cursor in the plots, under a unit of one input.
const lines = unpack(data.lines, Float64Array); // frequencies in the unit of the axis
const periods = unpack(data.periods, Float64Array);
const shapeSets = data.inputs.map(() => null); // unpacked when first shown

const page = {
  ...cycles,
  line: data.first.line,
  input: data.first.input,

  state() {
    return {
      frequency: lines[page.shownLine === undefined ? page.line : page.shownLine],
      input: data.inputs[page.input],
      cycle: data.cycle,
      magnification: data.figure.magnification,
    };
  },

  // Such as #f=2.5&input=1&t=0.25
  follow(fragment) {
    const parameters = new URLSearchParams(fragment.slice(1));
    const [frequency, input, time] = ["f", "input", "t"].map((key) => Number(parameters.get(key) || NaN));
    if (data.inputs[input - 1] !== undefined) page.input = input - 1;
    if (frequency > 0) page.line = nearestLine(frequency);
    if ([frequency, input, time].every(Number.isNaN)) return;
    select(page.line);
    pause();
    seek(Number.isFinite(time) ? time : 0);
  },
};

// The steady motion at a line: Re(u e^(2 pi i phase)).
class Deflection extends Motion {
  constructor(line, input) {
    super({
      names: data.names,
      times: { start: 0, end: 1, count: 2 },
      bytes: 4,
      values: data.names.map(() => 0),
      paths: data.figure.bodies.map(() => null),
    });
    const count = data.names.length;
    shapeSets[input] = shapeSets[input] || [data.real, data.imaginary].map((blocks) => unpack(blocks[input], Float32Array));
    [this.real, this.imaginary] = shapeSets[input].map((numbers) => numbers.subarray(line * count, (line + 1) * count));
  }

  value(i, phase) {
    return this.real[i] * Math.cos(2 * Math.PI * phase) - this.imaginary[i] * Math.sin(2 * Math.PI * phase);
  }
}

// Of the line that is nearest on a logarithmic axis.
function nearestLine(frequency) {
  const low = lastBefore(lines, frequency, lines.length - 1);
  const high = Math.min(low + 1, lines.length - 1);
  return frequency * frequency > lines[low] * lines[high] ? high : low;
}

function frequencyText(line) {
  return numberWithUnit(String(Number(lines[line].toPrecision(4))), data.axis);
}

// Shows the motion at a line, while the pointer is there or for good.
function display(line) {
  page.shownLine = line;
  player.motion = new Deflection(line, page.input);
  const factor = Number(unpack(data.factors[page.input], Float32Array)[line].toPrecision(2));
  const scale = data.moves && factor !== 1 ? `: displacements drawn × ${powerText(factor)}` : "";
  const about = `${data.inputs[page.input]} at ${frequencyText(line)}${scale}`;
  document.querySelector(".magnification").textContent = [data.note, about, paceText(periods[line])].filter(Boolean).join("\n");
  control("frequency").textContent = frequencyText(line);
  show(player.time);
}

function powerText(factor) {
  if (factor >= 1e-3 && factor < 1e5) return String(factor);
  const power = Math.floor(Math.log10(factor));
  return `${Number((factor / 10 ** power).toPrecision(2))}·10${superscript(power)}`;
}

// Puts the cursor of the plots at a line.
function select(line) {
  page.line = line;
  control("line").value = line;
  control("line").setAttribute("aria-valuetext", frequencyText(line));
  if (control("input")) control("input").value = page.input;
  document.querySelectorAll("tr[data-line]").forEach((row) => {
    markRow(row, Number(row.dataset.line) === line && Number(row.dataset.input) === page.input);
  });
  display(line);
  showInPlots(lines[line]);
}

function selectAndPlay(line) {
  select(line);
  playChosen();
}

control("line").addEventListener("input", (event) => selectAndPlay(Number(event.target.value)));
control("speed").addEventListener("change", () => display(page.line));
if (control("input")) {
  control("input").addEventListener("change", (event) => {
    page.input = Number(event.target.value);
    selectAndPlay(page.line);
  });
}
document.querySelectorAll("tr[data-line]").forEach((row) => {
  listenToRow(row, () => {
    page.input = Number(row.dataset.input);
    selectAndPlay(Number(row.dataset.line));
    row.querySelector("input").checked = true;
  });
});

plots.variable = "frequency";
plots.seek = (frequency) => selectAndPlay(nearestLine(frequency));
plots.pointed = (frequency) => {
  const line = frequency === null ? page.line : nearestLine(frequency);
  if (line !== page.shownLine && film.button === null) display(line); // a recording keeps its motion
};
open(new Deflection(page.line, page.input));
select(page.line);
window.mbconstrained.select = (frequency) => {
  if (!(frequency > 0)) throw new RangeError(`select: found ${frequency}; expected a positive frequency`);
  select(nearestLine(frequency));
};
