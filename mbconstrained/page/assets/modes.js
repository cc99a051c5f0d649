// The page of mode shapes: one cycle of each mode, of which the one that is picked is shown.
const page = {
  rate: 1 / data.cycle, // the time of the player is the part of the cycle
  mode: data.first,

  state() {
    const { name } = data.modes[page.mode];
    return { mode: page.mode + 1, name: name, cycle: data.cycle, magnification: data.figure.magnification };
  },

  shown() {},

  after(time) {
    return time % 1;
  },

  // Such as #mode=2&t=0.25
  follow(fragment) {
    const asked = new URLSearchParams(fragment.slice(1));
    const number = Number(asked.get("mode") || NaN);
    const time = Number(asked.get("t") || NaN);
    if (Number.isInteger(number) && data.modes[number - 1]) pick(number - 1);
    if (Number.isNaN(time) && Number.isNaN(number)) return;
    pause();
    seek(Number.isFinite(time) ? time : 0);
  },
};

const motions = data.modes.map(() => null); // unpacked when they are first shown

function motionOf(mode) {
  motions[mode] = motions[mode] || new Motion(Object.assign({ names: data.names }, data.modes[mode].frames));
  return motions[mode];
}

function pick(mode) {
  page.mode = mode;
  player.motion = motionOf(mode);
  const still = player.motion.end === player.motion.start;
  control("play").disabled = still;
  control("time").disabled = still;
  document.querySelectorAll("tr[data-mode]").forEach((row, i) => {
    row.classList.toggle("picked", i === mode);
    row.querySelector("input").checked = i === mode;
  });
  document.querySelectorAll(".details section").forEach((section, i) => (section.hidden = i !== mode));
  tell();
  if (still) player.playing = false;
  show(player.time);
}

// What is not as it is: size and pace.
function tell() {
  const { told } = data.modes[page.mode];
  document.querySelector(".magnification").textContent = [told, pace()].filter(Boolean).join("\n");
}

function pace() {
  const { period, frames } = data.modes[page.mode];
  if (frames.times.count === 1) return "";
  const shown = data.cycle / Number(control("speed").value);
  const plain = (number) => Number(number.toPrecision(3));
  if (period === null) return `no oscillation: its shape shown swaying, once in ${plain(shown)} s`;
  const factor = shown / period;
  const how = factor > 1 ? `slowed down ${plain(factor)} ×` : `sped up ${plain(1 / factor)} ×`;
  return `a cycle of ${plain(period)} s shown in ${plain(shown)} s` + (Math.abs(factor - 1) < 5e-4 ? "" : `: ${how}`);
}

// What is picked moves, unless the system is set to show as little motion as possible.
function pickAndPlay(mode) {
  pick(mode);
  if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) play();
}

control("speed").addEventListener("change", tell);
document.querySelectorAll("tr[data-mode]").forEach((row, i) => {
  const button = row.querySelector("input");
  button.addEventListener("change", () => pickAndPlay(i));
  row.addEventListener("click", (event) => {
    if (event.target.closest("label")) return; // the button hears of it by itself
    button.focus();
    pickAndPlay(i);
  });
});

open(motionOf(data.first));
pick(page.mode);
window.mbconstrained.pick = (number) => {
  if (!data.modes[number - 1]) throw new RangeError(`pick: found ${number}; expected a number from 1 to ${data.modes.length}`);
  pick(number - 1);
};
