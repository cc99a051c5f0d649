// The keyboard: what each key does while nothing else on the page wants it.
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

// What has keys of its own: the slider all but space, a radio button its arrows, a list of speeds everything.
function hasItsOwn(element, key) {
  if (document.querySelector("dialog[open]") || /^(SELECT|TEXTAREA)$/.test(element.tagName)) return true;
  if (element.tagName === "INPUT") return /^(Arrow|Home|End)/.test(key);
  if (/^(BUTTON|SUMMARY|A)$/.test(element.tagName)) return key === " ";
  return /^(Arrow|Home|End)/.test(key) && !["BODY", "HTML"].includes(element.tagName) && !element.closest(".motion");
}

// A share of the whole time further; past an end, that end.
function step(share) {
  seek(player.time + share * (player.motion.end - player.motion.start));
}

function speedUp(by) {
  const choice = control("speed");
  const wanted = choice.selectedIndex + by;
  if (!choice.options[wanted]) return;
  choice.selectedIndex = wanted;
  choice.dispatchEvent(new Event("change"));
  say(`speed ${choice.options[wanted].textContent}`);
}

document.addEventListener("keydown", (event) => {
  const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act || event.ctrlKey || event.altKey || event.metaKey || hasItsOwn(event.target, event.key)) return;
  event.preventDefault();
  act();
});
control("keys").addEventListener("click", keys["?"]);
control("close").addEventListener("click", () => control("help").close());
