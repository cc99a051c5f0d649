// Printing: browsers do not print WebGL canvases, so a flat copy of the picture with its names replaces it.
function copyForPaper() {
  const { viewer, size } = player.stage;
  const [width, height] = size;
  const flat = document.createElement("canvas");
  const sharp = viewer.renderer.domElement.width / width;
  Object.assign(flat, { className: "paper", width: sharp * width, height: sharp * height });
  const pen = flat.getContext("2d");
  player.stage.setTheme(false); // paper is light
  viewer.render();
  pen.drawImage(viewer.renderer.domElement, 0, 0, flat.width, flat.height);
  pen.scale(sharp, sharp);
  pen.font = "600 13px system-ui, Arial, sans-serif";
  pen.textAlign = "center";
  const pane = player.stage.pane.getBoundingClientRect();
  for (const label of player.stage.pane.querySelectorAll(".label")) {
    const box = label.getBoundingClientRect();
    if (label.style.visibility === "hidden" || !label.textContent) continue;
    pen.fillText(label.textContent.slice(0, 40), (box.left + box.right) / 2 - pane.left, box.bottom - pane.top - 4);
  }
  player.stage.pane.append(flat);
}

window.addEventListener("beforeprint", () => player.stage && copyForPaper());
window.addEventListener("afterprint", () => {
  document.querySelectorAll("canvas.paper").forEach((flat) => flat.remove());
  if (player.stage) player.stage.setTheme(theme.dark);
});
