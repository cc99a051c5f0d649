// The player: time, controls, and the state that programs can read and set. The last script defines an object `page` with
// what differs from page to page:
//   page.rate       seconds of the motion for a second of the viewer at speed 1
//   page.state()    further entries of the state
//   page.shown()    called after each change of time
//   page.pace(t)    a factor of the speed at a time, of pages that have one
//   page.after(t)   the time to continue from when the motion has passed its end
//   page.follow(fragment)  applies the part of the address after the #
const data = JSON.parse(document.getElementById("motion-data").textContent);
const control = (id) => document.getElementById(id);
const player = { time: 0, playing: false, published: 0, motion: null, stage: null, errors: [] };

const publishInterval = 100; // ms between published states while it plays

window.addEventListener("error", (event) => report(event.message));
window.addEventListener("unhandledrejection", (event) => report(String(event.reason)));
document.addEventListener("securitypolicyviolation", (event) => report(`blocked: ${event.blockedURI}`));

function report(message) {
  player.errors.push(message);
  document.body.dataset.state = JSON.stringify(state());
}

function state() {
  const coordinates = Object.create(null);
  if (player.motion) player.motion.at(player.time).forEach((value, i) => (coordinates[player.motion.names[i]] = value));
  return Object.assign(page.state(), {
    time: player.time,
    playing: player.playing,
    coordinates: coordinates,
    nodes: player.stage ? player.stage.nodes() : {},
    errors: player.errors,
  });
}

// Shows the state at a time; everything on the page that depends on the time is updated before it returns.
function show(time) {
  player.time = player.motion.clamp(time);
  if (data.figure.posing) leavePosing();
  if (player.stage) player.stage.show(player.motion, player.time);
  const text = `${player.time.toFixed(data.decimals)} ${data.unit}`;
  control("time").value = player.time;
  control("time").setAttribute("aria-valuetext", text);
  control("clock").textContent = text;
  page.shown();
  if (!player.playing || performance.now() - player.published > publishInterval) publish();
}

function publish() {
  player.published = performance.now();
  control("play").textContent = player.playing ? "Pause" : "Play";
  document.body.dataset.state = JSON.stringify(state());
}

// For assistive technology.
function announce(text) {
  control("announcement").textContent = text;
}

function seek(time) {
  if (!Number.isFinite(Number(time))) throw new RangeError(`seek: found ${time}; expected a time in seconds`);
  show(Number(time));
}

function play() {
  if (!player.playing) player.last = performance.now();
  player.playing = player.motion.end > player.motion.start;
  if (player.playing && player.time >= player.motion.end) show(player.motion.start);
  publish();
}

function pause() {
  player.playing = false;
  publish();
}

function toggle() {
  if (player.playing) pause();
  else play();
  announce(player.playing ? "playing" : `paused at ${control("clock").textContent}`);
}

function frame(now) {
  requestAnimationFrame(frame);
  if (player.playing) {
    const passed = Math.max(0, now - player.last) / 1000;
    const time = player.time + passed * Number(control("speed").value) * page.rate * (page.pace ? page.pace(player.time) : 1);
    const ended = time > player.motion.end;
    player.last = now;
    show(!ended ? time : film.recorder ? player.motion.end : page.after(time));
    filmFrame(ended);
  } else if (player.stage) {
    player.stage.drawIfNeeded();
  }
}

// What pages that show cycles share; the player's time is their phase, from 0 to 1.
const cycles = { rate: 1 / data.cycle, shown() {}, after: (time) => time % 1 };

// What is chosen moves, unless the system is set to reduced motion.
function playChosen() {
  if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) play();
}

function markRow(row, isChosen) {
  row.classList.toggle("selected", isChosen);
  row.querySelector("input").checked = isChosen;
}

// A row of a list is chosen by its button, or by a press anywhere in it.
function listenToRow(row, choose) {
  const button = row.querySelector("input");
  button.addEventListener("change", choose);
  row.addEventListener("click", (event) => {
    if (event.target.closest("label")) return; // the label activates the button itself
    button.focus();
    choose();
  });
}

// How much slower or faster than true a cycle is shown.
function paceText(period) {
  const shown = data.cycle / Number(control("speed").value);
  const rounded = (number) => Number(number.toPrecision(3));
  if (period === null) return `no oscillation: its shape is shown as an oscillation, once in ${rounded(shown)} s`;
  const factor = shown / period;
  const how = factor > 1 ? `slowed down ${rounded(factor)} ×` : `sped up ${rounded(1 / factor)} ×`;
  return `a cycle of ${rounded(period)} s shown in ${rounded(shown)} s` + (Math.abs(factor - 1) < 5e-4 ? "" : `: ${how}`);
}

function listen() {
  control("play").addEventListener("click", toggle);
  control("time").addEventListener("input", (event) => seek(event.target.value));
  control("reset").addEventListener("click", () => player.stage && player.stage.reset());
  control("more").addEventListener("click", () => {
    const all = document.querySelector(".motion").classList.toggle("all");
    control("more").setAttribute("aria-expanded", all);
    control("more").textContent = all ? "Less" : "More";
  });
  window.addEventListener("hashchange", () => page.follow(location.hash));
  window.addEventListener("themechange", () => player.stage && player.stage.setTheme(theme.dark));
  if (player.stage) listenToMarks(player.stage);
  if (player.stage && data.figure.posing) listenToSliders();
  offerRecordings();
}

const viewerMissing = "The 3-D view needs the file mbconstrained-viewer.js in the folder of this page.";

function open(motion) {
  player.motion = motion;
  try {
    if (!window.MeshCat) throw new Error(viewerMissing);
    player.stage = new Stage(control("stage"), data.figure);
    player.stage.setTheme(theme.dark);
  } catch (error) {
    control("stage").classList.add("unavailable");
    if (error.message === viewerMissing) document.querySelector(".missing").textContent = viewerMissing;
    report(`The 3-D view cannot be shown: ${error.message}`);
  }
  listen();
  show(motion.start);
  page.follow(location.hash);
  requestAnimationFrame(frame);
  const viewer = player.stage && player.stage.viewer;
  window.mbconstrained = { seek: seek, play: play, pause: pause, state: state, viewer: viewer };
}
