// Printing: browsers do not print WebGL canvases, so a flat copy of the picture with its names replaces it.

// Draws the picture with its names into a canvas; in colour: with the background and the colours of the page.
function paint(flat, inColour) {
  const { viewer, size, pane } = player.stage;
  const [width, height] = size;
  const sharp = viewer.renderer.domElement.width / width;
  const whole = [Math.round(sharp * width), Math.round(sharp * height)];
  if (flat.width !== whole[0] || flat.height !== whole[1]) Object.assign(flat, { width: whole[0], height: whole[1] });
  const pen = flat.getContext("2d");
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, ...whole);
  if (inColour) {
    pen.fillStyle = getComputedStyle(pane).backgroundColor;
    pen.fillRect(0, 0, ...whole);
  }
  viewer.render();
  pen.drawImage(viewer.renderer.domElement, 0, 0, ...whole);
  pen.scale(sharp, sharp);
  pen.font = "600 13px system-ui, Arial, sans-serif";
  pen.textAlign = "center";
  pen.fillStyle = inColour ? getComputedStyle(pane).color : "#000000";
  if (!player.stage.shows.names) return;
  const corner = pane.getBoundingClientRect();
  for (const label of pane.querySelectorAll(".label")) {
    const box = label.getBoundingClientRect();
    if (label.style.visibility === "hidden" || !label.textContent) continue;
    pen.fillText(label.textContent.slice(0, 40), (box.left + box.right) / 2 - corner.left, box.bottom - corner.top - 4);
  }
}

function copyForPaper() {
  const flat = document.createElement("canvas");
  flat.className = "paper";
  player.stage.setTheme(false); // paper is light
  paint(flat, false);
  player.stage.pane.append(flat);
}

window.addEventListener("beforeprint", () => player.stage && copyForPaper());
window.addEventListener("afterprint", () => {
  document.querySelectorAll("canvas.paper").forEach((flat) => flat.remove());
  if (player.stage) player.stage.setTheme(theme.dark);
});
