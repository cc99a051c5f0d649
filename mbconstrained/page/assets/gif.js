// The film as an animated GIF that repeats for ever (GIF89a of CompuServe, 1990): one palette for all pictures, from a sample of
// them; after the first picture only the rectangle that changes, transparent where it does not.
const gifRate = 25; // pictures a second: delays are in 1/100 s
const gifWidth = 640; // px, at most
const mostSamples = 32; // pictures that the palette is of: closer together than events are shown
const mostColors = 255; // and the number of the transparent one
const distinct = 65536; // colours that are told apart

async function saveGif() {
  const { start, end } = player.motion;
  const duration = 100 * filmDuration();
  const count = Math.max(1, Math.min(Math.round((gifRate * duration) / 100), mostFrames));
  const times = Array.from({ length: count }, (_, i) => start + (i / count) * (end - start));
  const sampled = times.filter((_, i) => i % Math.ceil(count / mostSamples) === 0);
  const [small, counts] = [document.createElement("canvas"), new Map()];
  let [gif, indexOf] = [null, null];
  await takePictures("gif", [...sampled, ...times], async (flat, i) => {
    const colors = shrunk(flat, small);
    const [from, to] = [0, 1].map((k) => Math.round((duration * (i - sampled.length + k)) / count));
    if (i === sampled.length) {
      const palette = paletteOf(counts);
      [gif, indexOf] = [new Gif(small.width, small.height, palette), nearest(palette)];
    }
    if (gif) gif.add(Uint8Array.from(colors, indexOf), to - from);
    else countColors(colors, counts);
    await nextTask();
  });
  if (gif) save(gif.parts(), "image/gif", "gif");
  else announce("stopped before the first picture");
}

// Lets the browser draw and listen; unlike a timer not slowed down in a hidden window.
function nextTask() {
  const { port1, port2 } = new MessageChannel();
  return new Promise((done) => {
    port1.onmessage = () => done(port1.close());
    port2.postMessage(null);
  });
}

// The pixels of a picture that is drawn smaller where it is wide: numbers with red in the lowest byte, then green and blue.
// The first picture decides the size.
function shrunk(flat, small) {
  if (!small.pen) {
    const scale = Math.min(1, gifWidth / flat.width);
    Object.assign(small, { width: Math.round(scale * flat.width), height: Math.round(scale * flat.height) });
    small.pen = Object.assign(small.getContext("2d", { willReadFrequently: true }), { imageSmoothingQuality: "high" });
  }
  small.pen.drawImage(flat, 0, 0, small.width, small.height);
  return new Uint32Array(small.pen.getImageData(0, 0, small.width, small.height).data.buffer);
}

function countColors(colors, counts) {
  for (const color of colors) {
    const key = keyOf(counts, color);
    counts.set(key, (counts.get(key) || 0) + 1);
  }
}

// A colour as the key of a map; in a map of many a colour near it, so that the map does not grow with the pictures.
const keyOf = (map, color) => (map.size < distinct || map.has(color) ? color : (color & 0xf8f8f8) | 0x040404);

const channels = (color) => [color & 255, (color >> 8) & 255, (color >> 16) & 255];

// Median cut (Heckbert 1982). The root of its count is the weight of a colour: the background is one of many, and the
// few pixels of an arrow or a letter count.
function paletteOf(counts) {
  const boxes = [boxOf(Array.from(counts, ([color, count]) => ({ rgb: channels(color), count: count, weight: Math.sqrt(count) })))];
  while (boxes.length < mostColors) {
    const largest = boxes.reduce((best, box, i) => (box.size > boxes[best].size ? i : best), 0);
    if (boxes[largest].size === 0) break;
    boxes.push(...halves(boxes.splice(largest, 1)[0]).map(boxOf));
  }
  return boxes.map(({ colors }) => {
    const total = sum(colors, ({ count }) => count);
    return [0, 1, 2].map((k) => Math.round(sum(colors, ({ rgb, count }) => count * rgb[k]) / total));
  });
}

const sum = (all, value) => all.reduce((total, each) => total + value(each), 0);

// Colours, the channel in which they differ most, and how much they do.
function boxOf(colors) {
  const weight = sum(colors, (color) => color.weight);
  const spreads = [0, 1, 2].map((k) => {
    const mean = sum(colors, (color) => color.weight * color.rgb[k]) / weight;
    return sum(colors, (color) => color.weight * (color.rgb[k] - mean) ** 2);
  });
  const size = colors.length > 1 ? Math.max(...spreads) : 0;
  return { colors: colors, size: size, channel: spreads.indexOf(Math.max(...spreads)) };
}

function halves({ colors, channel }) {
  colors.sort((a, b) => a.rgb[channel] - b.rgb[channel]);
  const half = sum(colors, ({ weight }) => weight) / 2;
  let [middle, before] = [0, 0];
  while (middle < colors.length - 1 && (middle === 0 || before < half)) before += colors[middle++].weight;
  return [colors.slice(0, middle), colors.slice(middle)];
}

// A function from a colour to the number of the nearest one in a palette.
function nearest(palette) {
  const known = new Map();
  let [last, found] = [null, 0]; // most pixels are like the one before
  return (color) => {
    if (color === last) return found;
    const key = keyOf(known, color);
    if (!known.has(key)) known.set(key, nearestTo(channels(key), palette));
    [last, found] = [color, known.get(key)];
    return found;
  };
}

function nearestTo([red, green, blue], palette) {
  let [best, least] = [0, Infinity];
  palette.forEach(([r, g, b], i) => {
    const distance = (r - red) ** 2 + (g - green) ** 2 + (b - blue) ** 2;
    if (distance < least) [best, least] = [i, distance];
  });
  return best;
}

class Gif {
  constructor(width, height, palette) {
    Object.assign(this, { width: width, height: height, shown: null });
    const table = Uint8Array.from({ length: 768 }, (_, i) => (palette[Math.floor(i / 3)] || [0, 0, 0])[i % 3]);
    const loop = [littleEndian("111", 0x21, 0xff, 11), "NETSCAPE2.0", littleEndian("1121", 3, 1, 0, 0)];
    this.written = ["GIF89a", littleEndian("22111", width, height, 0xf7, 0, 0), table, ...loop];
  }

  // A picture as numbers of colours, shown for so many 1/100 s.
  add(indices, delay) {
    const { shown, width } = this;
    const [left, top, right, bottom] = shown ? this.changed(indices) : [0, 0, width, this.height];
    const cut = new Uint8Array((right - left) * (bottom - top));
    for (let [y, i] = [top, 0]; y < bottom; y++) {
      for (let k = y * width + left; k < y * width + right; k++) cut[i++] = shown && shown[k] === indices[k] ? mostColors : indices[k];
    }
    this.shown = indices;
    this.written.push(
      littleEndian("1111211", 0x21, 0xf9, 4, shown ? 5 : 4, delay, mostColors, 0), // stays, transparent after the first
      littleEndian("1222211", 0x2c, left, top, right - left, bottom - top, 0, 8),
      compressed(cut),
    );
  }

  // The rectangle that differs from the picture before, at least a pixel.
  changed(indices) {
    let [left, top, right, bottom] = [this.width, this.height, 0, 0];
    for (let k = 0; k < indices.length; k++) {
      if (indices[k] === this.shown[k]) continue;
      const [x, y] = [k % this.width, Math.floor(k / this.width)];
      [left, top, right, bottom] = [Math.min(left, x), Math.min(top, y), Math.max(right, x + 1), Math.max(bottom, y + 1)];
    }
    return right ? [left, top, right, bottom] : [0, 0, 1, 1];
  }

  parts() {
    return [...this.written, littleEndian("1", 0x3b)];
  }
}

const codes = new Uint16Array(4096 * 256); // LZW: of a string and the byte after it, 0 for none

// LZW with codes of 9 to 12 bits (appendix F of the specification), in blocks of at most 255 bytes after their length.
function compressed(indices) {
  const [clear, end, bytes] = [256, 257, []];
  let [held, bits, size, next] = [0, 0, 9, 0];
  const append = (byte) => (bytes.length % 256 ? bytes.push(byte) : bytes.push(255, byte));
  const put = (code) => {
    held |= code << bits;
    for (bits += size; bits >= 8; bits -= 8, held >>>= 8) append(held & 255);
  };
  const grow = () => (size += next === 1 << size && size < 12 ? 1 : 0);
  const restart = () => {
    put(clear);
    codes.fill(0);
    [size, next] = [9, 258];
  };
  restart();
  let string = indices[0];
  for (const index of indices.subarray(1)) {
    const place = 256 * string + index;
    const longer = codes[place];
    if (!longer) {
      put(string);
      grow();
      if (next < 4096) codes[place] = next++;
      else restart();
    }
    string = longer || index;
  }
  put(string);
  grow();
  put(end);
  if (bits) append(held);
  const last = bytes.length - (bytes.length % 256 || 256);
  bytes[last] = bytes.length - last - 1;
  return Uint8Array.from([...bytes, 0]);
}
