// The page of a run: one motion, and plots whose cursors follow it.
const slowest = 0.1; // factor of the speed at an event, on request

const page = {
  rate: 1,
  plots: typeof plots === "undefined" ? null : plots, // their script is included only where needed

  state() {
    const { start, end } = player.motion;
    return { duration: end - start, loop: page.loops(), pace: page.pace(player.time), magnification: data.figure.magnification };
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

  // Slower near an event, the nearer the slower; of events that follow each other closely only the time between them counts as near.
  pace(time) {
    if (!control("slow") || !control("slow").checked) return 1;
    const { start, end } = player.motion;
    const times = [start, ...data.figure.overlay.events.map((event) => event.time), end];
    const next = times.findIndex((each, i) => each > time || i === times.length - 1);
    const near = Math.min((end - start) / 20, (times[next] - times[next - 1]) / 3);
    const distances = [next - 1, next].filter((i) => i > 0 && i < times.length - 1).map((i) => Math.abs(times[i] - time));
    return near > (end - start) / 1000 ? Math.min(1, Math.max(slowest, Math.min(...distances) / near)) : 1;
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
