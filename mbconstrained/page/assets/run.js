// The page of a run: one motion, and plots whose cursors follow it.
const page = {
  rate: 1,

  state() {
    const { start, end } = player.motion;
    return { duration: end - start, magnification: data.figure.magnification };
  },

  shown() {
    document.querySelectorAll("svg.plot").forEach(moveCursor);
  },

  after() {
    return player.motion.start;
  },

  follow(fragment) {
    const asked = /^#t=(.+)$/.exec(fragment);
    if (!asked || !Number.isFinite(Number(asked[1]))) return;
    pause();
    seek(asked[1]);
  },
};

function moveCursor(plot) {
  const { start, end, left, right } = plot.dataset;
  const share = (player.time - start) / (end - start);
  const cursor = plot.querySelector(".cursor");
  cursor.setAttribute("transform", `translate(${(Number(left) + share * (right - left)).toFixed(2)} 0)`);
  cursor.setAttribute("visibility", share >= 0 && share <= 1 ? "visible" : "hidden");
}

function pick(plot, event) {
  const { start, end, left, right } = plot.dataset;
  const x = new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.getScreenCTM().inverse()).x;
  seek(Number(start) + ((x - left) / (right - left)) * (end - start));
}

document.querySelectorAll("svg.plot").forEach((plot) => plot.addEventListener("click", (event) => pick(plot, event)));
open(new Motion(data.frames));
