// The page of a run: one motion, and plots whose cursors follow it.
const page = {
  rate: 1,
  plots: typeof plots === "undefined" ? null : plots, // without plots there is no script of theirs

  state() {
    const { start, end } = player.motion;
    return { duration: end - start, loop: page.loops(), magnification: data.figure.magnification };
  },

  shown() {
    if (page.plots) showInPlots(player.time);
  },

  loops() {
    return control("loop").getAttribute("aria-pressed") === "true";
  },

  after() {
    if (page.loops()) return player.motion.start;
    pause();
    return player.motion.end;
  },

  follow(fragment) {
    const asked = /^#t=(.+)$/.exec(fragment);
    if (!asked || !Number.isFinite(Number(asked[1]))) return;
    pause();
    seek(asked[1]);
  },
};

control("loop").addEventListener("click", () => {
  control("loop").setAttribute("aria-pressed", !page.loops());
  say(page.loops() ? "starts again at the end" : "stops at the end");
  publish();
});
if (page.plots) {
  plots.seek = seek;
  plots.read = (coordinate, time) => player.motion.value(coordinate, time);
}
open(new Motion(data.frames));
