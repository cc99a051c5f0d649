// Keyboard shortcuts, for keys that the focused element does not use.
const keys = {
  " ": toggle,
  ArrowLeft: () => step(-0.01),
  ArrowRight: () => step(0.01),
  Home: () => seek(player.motion.start),
  End: () => seek(player.motion.end),
  "+": () => speedUp(1),
  "-": () => speedUp(-1),
  l: () => control("loop") && control("loop").click(),
  "?": () => control("help").showModal(),
};

// Whether an element uses a key itself.
function usesKey(element, key) {
  if (document.querySelector("dialog[open]") || /^(SELECT|TEXTAREA)$/.test(element.tagName)) return true;
  if (element.tagName === "INPUT") return /^(Arrow|Home|End)/.test(key);
  if (/^(BUTTON|SUMMARY|A)$/.test(element.tagName)) return key === " ";
  return /^(Arrow|Home|End)/.test(key) && !["BODY", "HTML"].includes(element.tagName) && !element.closest(".motion");
}

// Moves the time by a share of the duration, at most to an end.
function step(share) {
  seek(player.time + share * (player.motion.end - player.motion.start));
}

function speedUp(by) {
  const choice = control("speed");
  const wanted = choice.selectedIndex + by;
  if (!choice.options[wanted]) return;
  choice.selectedIndex = wanted;
  choice.dispatchEvent(new Event("change"));
  announce(`speed ${choice.options[wanted].textContent}`);
}

document.addEventListener("keydown", (event) => {
  const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act || event.ctrlKey || event.altKey || event.metaKey || usesKey(event.target, event.key)) return;
  event.preventDefault();
  act();
});
control("keys").addEventListener("click", keys["?"]);
control("close").addEventListener("click", () => control("help").close());
