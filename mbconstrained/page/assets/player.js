// The player: time, controls, the cursors of the plots, and the state that programs can read and set.
const data = JSON.parse(document.getElementById("motion-data").textContent);
const motion = new Motion(data.frames);
const control = (id) => document.getElementById(id);
const player = { time: motion.start, playing: false, stage: null, errors: [] };

window.addEventListener("error", (event) => report(event.message));
window.addEventListener("unhandledrejection", (event) => report(String(event.reason)));
document.addEventListener("securitypolicyviolation", (event) => report(`blocked: ${event.blockedURI}`));

function report(message) {
  player.errors.push(message);
  document.body.dataset.state = JSON.stringify(state());
}

function state() {
  const coordinates = Object.create(null);
  motion.at(player.time).forEach((value, i) => (coordinates[motion.names[i]] = value));
  return {
    time: player.time,
    duration: motion.end - motion.start,
    playing: player.playing,
    coordinates: coordinates,
    nodes: player.stage ? player.stage.nodes() : {},
    magnification: data.figure.magnification,
    errors: player.errors,
  };
}

// Shows the state at a time; everything on the page that depends on the time is written before it returns.
function show(time) {
  player.time = motion.clamp(time);
  if (player.stage) player.stage.show(motion.at(player.time));
  control("time").value = player.time;
  control("clock").textContent = `${player.time.toFixed(data.decimals)} s`;
  document.querySelectorAll("svg.plot").forEach(moveCursor);
  publish();
}

function publish() {
  control("play").textContent = player.playing ? "Pause" : "Play";
  control("play").setAttribute("aria-pressed", player.playing);
  document.body.dataset.state = JSON.stringify(state());
}

function moveCursor(plot) {
  const { start, end, left, right } = plot.dataset;
  const share = (player.time - start) / (end - start);
  const cursor = plot.querySelector(".cursor");
  cursor.setAttribute("transform", `translate(${(Number(left) + share * (right - left)).toFixed(2)} 0)`);
  cursor.setAttribute("visibility", share >= 0 && share <= 1 ? "visible" : "hidden");
}

function seek(time) {
  if (!Number.isFinite(Number(time))) throw new RangeError(`seek: found ${time}; expected a time in seconds`);
  show(Number(time));
}

function play() {
  player.playing = motion.end > motion.start;
  player.last = performance.now();
  publish();
}

function pause() {
  player.playing = false;
  publish();
}

function toggle() {
  if (player.playing) pause();
  else play();
}

function frame(now) {
  requestAnimationFrame(frame);
  if (player.playing) {
    const time = player.time + (Math.max(0, now - player.last) / 1000) * Number(control("speed").value);
    player.last = now;
    show(time > motion.end ? motion.start : time);
  } else if (player.stage) {
    player.stage.drawIfNeeded();
  }
}

function followAddress() {
  const asked = /^#t=(.+)$/.exec(location.hash);
  if (!asked || !Number.isFinite(Number(asked[1]))) return;
  pause();
  seek(asked[1]);
}

function pick(plot, event) {
  const { start, end, left, right } = plot.dataset;
  const x = new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.getScreenCTM().inverse()).x;
  seek(Number(start) + ((x - left) / (right - left)) * (end - start));
}

function listen() {
  control("play").addEventListener("click", toggle);
  control("time").addEventListener("input", (event) => seek(event.target.value));
  control("reset").addEventListener("click", () => player.stage && player.stage.reset());
  document.addEventListener("keydown", (event) => {
    if (event.key !== " " || /^(BUTTON|SELECT|SUMMARY|A)$/.test(event.target.tagName)) return;
    event.preventDefault();
    toggle();
  });
  window.addEventListener("hashchange", followAddress);
  document.querySelectorAll("svg.plot").forEach((plot) => plot.addEventListener("click", (event) => pick(plot, event)));
}

function open() {
  try {
    player.stage = new Stage(control("stage"), data.figure);
  } catch (error) {
    control("stage").classList.add("unavailable");
    report(`The 3-D view cannot be shown: ${error.message}`);
  }
  listen();
  show(motion.start);
  followAddress();
  requestAnimationFrame(frame);
}

open();
window.mbconstrained = { seek: seek, play: play, pause: pause, state: state, viewer: player.stage && player.stage.viewer };
