// Printing: browsers do not print WebGL canvases, so a flat copy of the picture with its names replaces it.

// Draws the picture with its names into a canvas, in the task that has drawn it on the page; in colour: with the background,
// the text over the picture and the colours of the page.
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
  pen.drawImage(viewer.renderer.domElement, 0, 0, ...whole);
  pen.scale(sharp, sharp);
  if (player.stage.shows.names) paintNames(pen, pane, inColour);
  if (inColour) paintText(pen, pane, pane.querySelector(".magnification"));
}

function paintNames(pen, pane, inColour) {
  const corner = pane.getBoundingClientRect();
  for (const label of pane.querySelectorAll(".label")) {
    const box = label.getBoundingClientRect();
    if (label.style.visibility === "hidden" || !label.textContent) continue;
    const { font, color, opacity } = getComputedStyle(label);
    Object.assign(pen, { font: font, textAlign: "center", fillStyle: inColour ? color : "#000000", globalAlpha: opacity });
    pen.fillText(label.textContent.slice(0, 40), (box.left + box.right) / 2 - corner.left, box.bottom - corner.top - 4);
  }
  pen.globalAlpha = 1;
}

// Draws a paragraph line by line where it is on the page.
function paintText(pen, pane, paragraph) {
  const { font, color } = getComputedStyle(paragraph);
  Object.assign(pen, { font: font, textAlign: "left", fillStyle: color });
  const corner = pane.getBoundingClientRect();
  const { fontBoundingBoxDescent: descent } = pen.measureText("x");
  for (const { text, left, bottom } of linesOf(paragraph)) pen.fillText(text, left - corner.left, bottom - corner.top - descent);
}

// The lines into which the page breaks a paragraph of plain text, and their places in the window.
function linesOf(paragraph) {
  const lines = [];
  const range = document.createRange();
  const words = paragraph.firstChild;
  for (let i = 0; words && i < words.length; i += 1) {
    range.setStart(words, i);
    range.setEnd(words, i + 1);
    const { left, bottom, width } = range.getBoundingClientRect();
    if (!width && /\s/.test(words.data[i])) continue; // a break, or a space that is not shown
    if (!lines.length || bottom > lines.at(-1).bottom + 1) lines.push({ text: "", left: left, bottom: bottom });
    lines.at(-1).text += words.data[i];
  }
  return lines;
}

function copyForPaper() {
  const flat = document.createElement("canvas");
  flat.className = "paper";
  player.stage.setTheme(false); // paper is light
  player.stage.draw();
  paint(flat, false);
  player.stage.pane.append(flat);
}

window.addEventListener("beforeprint", () => player.stage && copyForPaper());
window.addEventListener("afterprint", () => {
  document.querySelectorAll("canvas.paper").forEach((flat) => flat.remove());
  if (player.stage) player.stage.setTheme(theme.dark);
});
