// The pictures of a film one by one: PNG files in a ZIP archive, from the start to the end of the motion at the chosen speed.
async function saveFrames() {
  const { start, end } = player.motion;
  const steps = Math.min(framesPerSecond * filmDuration(), mostFrames - 1);
  const times = Array.from({ length: Math.floor(steps + 1e-6) + 1 }, (_, i) => start + (i / steps) * (end - start));
  const files = [];
  await takePictures("frames", times, async (flat, i) => {
    const blob = await new Promise((done) => flat.toBlob(done));
    files.push({ name: `frame_${String(i + 1).padStart(4, "0")}.png`, bytes: new Uint8Array(await blob.arrayBuffer()) });
  });
  save(archive(files), "application/zip", "zip");
}

// The files as they are, one after the other, then their directory (APPNOTE.TXT of PKWARE, 4.3.7, 4.3.12 and 4.3.16).
function archive(files) {
  const [parts, directory] = [[], []];
  let [place, length] = [0, 0];
  for (const { name, bytes } of files) {
    const title = new TextEncoder().encode(name);
    // version, flags, method, time, date (the first day of 1980), checksum, both sizes, lengths of the name and of what follows it
    const facts = littleEndian("2222244422", 20, 0, 0, 0, 0x21, checksum(bytes), bytes.length, bytes.length, title.length, 0);
    directory.push(littleEndian("42", 0x02014b50, 20), facts, littleEndian("22244", 0, 0, 0, 0, place), title);
    parts.push(littleEndian("4", 0x04034b50), facts, title, bytes);
    place += 4 + facts.length + title.length + bytes.length;
  }
  for (const part of directory) length += part.length;
  return [...parts, ...directory, littleEndian("42222442", 0x06054b50, 0, 0, files.length, files.length, length, place, 0)];
}

// Numbers of so many bytes each.
function littleEndian(sizes, ...numbers) {
  return Uint8Array.from([...sizes].flatMap((size, i) => Array.from({ length: Number(size) }, (_, k) => (numbers[i] >>> (8 * k)) & 255)));
}

const checksums = Uint32Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; bit++) byte = byte & 1 ? 0xedb88320 ^ (byte >>> 1) : byte >>> 1;
  return byte;
});

// CRC-32 of ISO 3309.
function checksum(bytes) {
  let sum = 0xffffffff;
  for (const byte of bytes) sum = checksums[(sum ^ byte) & 255] ^ (sum >>> 8);
  return (sum ^ 0xffffffff) >>> 0;
}
