// The page of a run: one motion, and plots whose cursors follow it.
const page = {
  rate: 1,
  plots: typeof plots === "undefined" ? null : plots, // their script is included only where needed

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
    const match = /^#t=(.+)$/.exec(fragment);
    if (!match || !Number.isFinite(Number(match[1]))) return;
    pause();
    seek(match[1]);
  },
};

control("loop").addEventListener("click", () => {
  control("loop").setAttribute("aria-pressed", !page.loops());
  announce(page.loops() ? "loops at the end" : "stops at the end");
  publish();
});
// The rows of a table of events lead to their times, also when the address is that of the row already.
for (const link of document.querySelectorAll('a[href^="#t="]')) {
  link.closest("tr").addEventListener("click", () => page.follow(link.hash));
}
if (page.plots) plots.seek = seek;
open(new Motion(data.frames));
