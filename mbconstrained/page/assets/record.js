// Recording: the picture with its names and the text over it as a WebM film, once from the start to the end of the motion
// at the chosen speed.
const film = { recorder: null, flat: null, savesFrames: false };

const filmFormat = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find(
  (format) => window.MediaRecorder && HTMLCanvasElement.prototype.captureStream && MediaRecorder.isTypeSupported(format),
);

const framesPerSecond = 30;

function startFilm() {
  film.flat = document.createElement("canvas");
  seek(player.motion.start);
  paint(film.flat, true);
  const parts = [];
  film.recorder = new MediaRecorder(film.flat.captureStream(framesPerSecond), { mimeType: filmFormat, videoBitsPerSecond: 8e6 });
  film.recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  film.recorder.addEventListener("stop", () => save(new Blob(parts, { type: "video/webm" }), "webm"));
  film.recorder.start();
  control("record").textContent = "Stop recording";
  announce("recording");
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
  control("record").textContent = "Record";
  pause();
  announce("recorded");
}

function save(blob, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${document.title.replace(/[^\p{L}\p{N}]+/gu, "_").slice(0, 60) || "motion"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

function offerFilm() {
  if (!player.stage || player.motion.end === player.motion.start) return;
  control("frames").hidden = false;
  control("frames").addEventListener("click", () => (film.savesFrames ? (film.savesFrames = false) : saveFrames()));
  if (!filmFormat) return;
  control("record").hidden = false;
  control("record").addEventListener("click", () => (film.recorder ? endFilm() : startFilm()));
}
