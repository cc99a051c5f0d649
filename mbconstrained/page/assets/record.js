// Recording: the picture with its names and the text over it as a WebM film, once from the start to the end of the motion
// at the chosen speed; and what all recordings share.
const film = { recorder: null, flat: null, button: null, stopped: false }; // button: the one that records now

const filmFormat = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find(
  (format) => window.MediaRecorder && HTMLCanvasElement.prototype.captureStream && MediaRecorder.isTypeSupported(format),
);

const framesPerSecond = 30;
const mostFrames = 1000; // of pictures that are saved one by one; those of a longer film are further apart

function startFilm() {
  film.flat = document.createElement("canvas");
  seek(player.motion.start);
  paint(film.flat, true);
  const parts = [];
  film.recorder = new MediaRecorder(film.flat.captureStream(framesPerSecond), { mimeType: filmFormat, videoBitsPerSecond: 8e6 });
  film.recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  film.recorder.addEventListener("stop", () => save(parts, "video/webm", "webm"));
  film.recorder.start();
  setRecording("record");
  control("record").textContent = "Stop";
  play();
}

// Called by the player after each frame: `ended` once the motion has passed its end.
function filmFrame(ended) {
  if (!film.recorder) return;
  paint(film.flat, true);
  if (ended) endFilm();
}

const lastShown = 300; // ms, for which the film stays at its last frame: of less a recorder keeps nothing

function endFilm() {
  const { recorder } = film;
  setTimeout(() => recorder.stop(), lastShown);
  film.recorder = null;
  setRecording(null);
  control("record").textContent = "Record";
  pause();
}

// How long the motion takes at the chosen speed, in s.
function filmDuration() {
  return (player.motion.end - player.motion.start) / (Number(control("speed").value) * page.rate);
}

// Shows the motion at each time and gives the picture to a function, until its button is pressed again or another motion is chosen.
async function takePictures(button, times, take) {
  const { motion } = player;
  const [label, flat] = [control(button).textContent, document.createElement("canvas")];
  setRecording(button);
  film.stopped = false;
  try {
    for (let i = 0; i < times.length && !film.stopped && player.motion === motion; i++) {
      player.playing = false;
      seek(times[i]);
      paint(flat, true);
      await take(flat, i);
      control(button).textContent = `Stop at ${Math.round((100 * (i + 1)) / times.length)} %`;
    }
  } finally {
    setRecording(null);
    control(button).textContent = label;
    publish();
  }
}

function save(parts, type, ending) {
  announce(`saved ${saveFile(parts, type, document.title, ending)}`);
}

const recordings = { frames: saveFrames, gif: saveGif, record: filmFormat && startFilm };

// While one button records, only that one can be pressed; none can where nothing moves.
function setRecording(button) {
  film.button = button;
  const isStill = player.motion.end === player.motion.start;
  for (const id in recordings) control(id).disabled = isStill || (button !== null && button !== id);
  if (button !== null) announce("recording");
}

function offerRecordings() {
  if (!player.stage || player.motion.end === player.motion.start) return;
  const stop = () => (film.recorder ? endFilm() : (film.stopped = true));
  for (const [id, start] of Object.entries(recordings)) {
    control(id).hidden = !start;
    control(id).addEventListener("click", () => (film.button === id ? stop() : start()));
  }
}
