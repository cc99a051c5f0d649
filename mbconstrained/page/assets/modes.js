// The page of mode shapes: one cycle of the selected mode.
const page = {
  ...cycles,
  mode: data.first,

  state() {
    const { name } = data.modes[page.mode];
    return { mode: page.mode + 1, name: name, cycle: data.cycle, magnification: data.figure.magnification };
  },

  // Such as #mode=2&t=0.25
  follow(fragment) {
    const parameters = new URLSearchParams(fragment.slice(1));
    const number = Number(parameters.get("mode") || NaN);
    const time = Number(parameters.get("t") || NaN);
    if (Number.isInteger(number) && data.modes[number - 1]) select(number - 1);
    if (Number.isNaN(time) && Number.isNaN(number)) return;
    pause();
    seek(Number.isFinite(time) ? time : 0);
  },
};

const motions = data.modes.map(() => null); // unpacked when first shown

const rowsOfModes = document.querySelectorAll("tr[data-mode]"); // those of zero eigenvalues are the last

function motionOf(mode) {
  motions[mode] = motions[mode] || new Motion(Object.assign({ names: data.names }, data.modes[mode].frames));
  return motions[mode];
}

function select(mode) {
  page.mode = mode;
  player.motion = motionOf(mode);
  const isStill = player.motion.end === player.motion.start;
  for (const id of ["play", "time"]) control(id).disabled = isStill;
  for (const row of rowsOfModes) {
    const isHere = Number(row.dataset.mode) === mode;
    markRow(row, isHere);
    if (isHere && row.closest("details")) row.closest("details").open = true;
  }
  document.querySelectorAll(".details section").forEach((section, i) => (section.hidden = i !== mode));
  if (control("choice")) {
    control("choice").value = mode;
    control("choice").setAttribute("aria-valuetext", data.modes[mode].name);
    control("chosen").textContent = data.modes[mode].name;
  }
  showNote();
  if (isStill) player.playing = false;
  if (isStill && film.recorder) endFilm(); // a motion that does not play has no end
  setRecording(film.button);
  show(player.time);
}

// The factors of size and time.
function showNote() {
  const { note } = data.modes[page.mode];
  document.querySelector(".magnification").textContent = [note, pace()].filter(Boolean).join("\n");
}

function pace() {
  const { period, frames } = data.modes[page.mode];
  return frames.times.count === 1 ? "" : paceText(period);
}

function selectAndPlay(mode) {
  select(mode);
  playChosen();
}

control("speed").addEventListener("change", showNote);
if (control("choice")) control("choice").addEventListener("input", (event) => selectAndPlay(Number(event.target.value)));
for (const row of rowsOfModes) listenToRow(row, () => selectAndPlay(Number(row.dataset.mode)));

open(motionOf(data.first));
select(page.mode);
window.mbconstrained.select = (number) => {
  if (!data.modes[number - 1]) throw new RangeError(`select: found ${number}; expected a number from 1 to ${data.modes.length}`);
  select(number - 1);
};
