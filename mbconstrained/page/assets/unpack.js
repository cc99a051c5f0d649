// Decompresses and runs the scripts: first the viewer, then the data, then the page's own script.
(async function () {
  "use strict";

  async function unpacked(element) {
    const bytes = Uint8Array.from(atob(element.textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  function add(name, text) {
    const script = document.createElement("script");
    if (name.endsWith("-data")) Object.assign(script, { type: "application/json", id: name });
    script.textContent = text;
    document.body.append(script);
  }

  if (!("DecompressionStream" in window)) {
    document.getElementById("stage").classList.add("unavailable");
    document.querySelector(".missing").textContent =
      "The animation on this page is compressed, and this browser is too old to decompress it: " +
      "use a newer one, or write the page without compression.";
    return;
  }
  const packed = [...document.querySelectorAll("[data-content]")];
  const texts = await Promise.all(packed.map(unpacked));
  packed.forEach((element, i) => add(element.dataset.content, texts[i]));
})();
