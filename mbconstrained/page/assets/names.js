// Names over the bodies, and the labels of arrows.

// Outer radius of wheels with teeth or rim, relative to their size.
const wheels = { disc: 1, gear: 1.05, ring: 1.14 };

class Names {
  // boxes: corners of a box around each body of solids, in its own frame; null for others.
  constructor(stage, boxes) {
    this.stage = stage;
    this.boxes = boxes;
    this.drawn = stage.figure.bodies;
    this.box = stage.pane.querySelector(".labels");
    this.labels = this.drawn.map(({ label }) => this.label(label));
    const named = this.drawn.filter(({ label }) => label);
    this.box.classList.toggle("many", named.length > (named.some(({ shape }) => shape === "solids") ? 8 : 24));
    this.hidden = null; // computed when first needed after each change of the view
    this.sides = null;
    this.lines = [];
  }

  label(text) {
    const label = document.createElement("span");
    label.className = "label";
    label.textContent = text;
    this.box.append(label);
    return label;
  }

  viewChanged() {
    this.hidden = null;
    this.sides = null; // chosen anew, too
  }

  // The middle of a body and half of its width and height in the view, in pixels.
  outline(i) {
    const { shape, size, rest_turn } = this.drawn[i];
    const turn = this.stage.turn.clone().multiply(quaternionOf(rest_turn));
    const middle = this.stage.bodies[i].getWorldPosition(new THREE.Vector3()); // in axes with y up
    const [x, y] = this.stage.pixels(middle);
    const reach = (axis) => {
      const [along, back, upwards] = new THREE.Vector3(...axis).applyQuaternion(turn).toArray();
      const end = this.stage.pixels(middle.clone().add(new THREE.Vector3(along, upwards, -back)));
      return [Math.abs(end[0] - x), Math.abs(end[1] - y)];
    };
    const axes = [reach([size[0] / 2, 0, 0]), reach([0, size[1] / 2, 0]), reach([0, 0, size[2] / 2])];
    const half = [0, 1].map((k) => {
      const [across, away, up] = axes.map((axis) => axis[k]);
      return (wheels[shape] ? wheels[shape] * Math.hypot(across, up) : across + up) + away;
    });
    return { x: x, y: y, across: half[0], up: half[1] };
  }

  // The boxes in which the name of a body may be, in pixels: above it, to its right, to its left, below it; on a solid one, or a line
  // higher or lower there.
  places(i) {
    const [width, height] = this.sizes[i];
    const box = (x, y) => ({ left: x - width / 2, right: x + width / 2, top: y - height, bottom: y });
    if (this.boxes[i]) {
      const [x, top] = this.onSolid(i);
      return [0, -height, height].map((shift) => box(x, top - 4 + shift));
    }
    const { x, y, across, up } = this.outline(i);
    const [aside, level] = [across + width / 2 + 4, y + height / 2];
    return [box(x, y - up - 4), box(x + aside, level), box(x - aside, level), box(x, y + up + height + 4)];
  }

  // The first of these places in which a name covers no link, no other body and no other name; else the first.
  side(i, places, occupied) {
    const [width, height] = this.stage.size;
    const others = this.drawn.flatMap(({ shape }, k) => {
      if (k === i || this.boxes[k] || shape === "rail" || shape === "base") return [];
      const { x, y, across, up } = this.outline(k);
      return [{ left: x - across, right: x + across, top: y - up, bottom: y + up }];
    });
    const isInside = (box) => box.left > 0 && box.right < width && box.top > 0 && box.bottom < height;
    const near = Math.max(8, this.stage.pixelsOf(0.25)); // a little more than half the width of a spring
    const besides = (box) => isFree(box, others) && this.lines.every((line) => !crosses(box, line, near));
    const isClear = (box) => isFree(box, occupied) && (this.boxes[i] || besides(box));
    return Math.max(places.findIndex((box) => isInside(box) && isClear(box)), 0);
  }

  // The links as lines in the view, in pixels.
  lineOf({ ends, drawn }) {
    return ends.map((end) => this.stage.pixels(drawn.object.parent.localToWorld(end.clone())));
  }

  // On the middle of the largest solid of a body, or just above it where that is flat.
  onSolid(i) {
    const corners = this.boxes[i].map((corner) => this.stage.pixels(this.stage.bodies[i].localToWorld(corner.clone())));
    const [xs, ys] = [0, 1].map((axis) => corners.map((corner) => corner[axis]));
    const middle = (numbers) => (Math.min(...numbers) + Math.max(...numbers)) / 2;
    return [middle(xs), Math.max(Math.min(...ys), middle(ys) - 12)];
  }

  // Which bodies of solids are hidden by others: their names would be read as those of the bodies in front.
  behind() {
    const solids = this.stage.bodies.map((body) => opaque(body));
    const own = (i, { object }) => solids[i].includes(object);
    const caster = new THREE.Raycaster();
    const covered = (i, point) => {
      const projected = point.clone().project(this.stage.camera);
      caster.setFromCamera(new THREE.Vector2(projected.x, projected.y), this.stage.camera);
      const [first] = hitsOf(caster, solids.flat());
      return Boolean(first) && !own(i, first) && first.distance < caster.ray.origin.distanceTo(point);
    };
    const hidden = (i) => pointsAlong(this.boxes[i]).every((point) => covered(i, this.stage.bodies[i].localToWorld(point)));
    return this.drawn.map(({ label }, i) => Boolean(this.boxes[i] && label) && hidden(i));
  }

  // Places the names next to their bodies, on the side that was clear when the view was chosen; a name that would cover
  // another one or an occupied box, or belongs to a hidden body, is left out.
  place(occupied) {
    this.hidden = this.hidden || this.behind();
    this.sizes = this.sizes || this.labels.map(({ offsetWidth, offsetHeight }) => [offsetWidth, offsetHeight]);
    const chosen = Boolean(this.sides);
    this.sides = this.sides || this.drawn.map(() => 0);
    if (!chosen) this.lines = this.stage.links.filter(({ ends }) => ends).map((link) => this.lineOf(link));
    for (const i of this.order()) {
      const [label, places] = [this.labels[i], this.places(i)];
      if (!chosen && label.textContent) this.sides[i] = this.side(i, places, occupied);
      const box = this.inside(places[this.sides[i]]);
      label.style.transform = `translate(${box.left.toFixed(1)}px, ${box.top.toFixed(1)}px)`;
      const shown = isFree(box, occupied) && !this.hidden[i];
      label.style.visibility = shown ? "visible" : "hidden";
      if (shown && label.textContent) occupied.push(box);
    }
  }

  // The text over the picture, where no name may be.
  caption() {
    const text = this.stage.pane.querySelector(".magnification");
    const state = [text.textContent, ...this.stage.size].join();
    if (state === this.captionState) return this.captionBoxes;
    const range = document.createRange();
    range.selectNodeContents(text);
    const [{ left, right, top, bottom, width }, corner] = [range, this.stage.pane].map((part) => part.getBoundingClientRect());
    const box = { left: left - corner.left, right: right - corner.left, top: top - corner.top, bottom: bottom - corner.top };
    return Object.assign(this, { captionState: state, captionBoxes: width ? [box] : [] }).captionBoxes;
  }

  // A box that is partly outside of the picture, moved into it.
  inside(box) {
    const [width, height] = this.stage.size;
    const shift = (low, high, end) => (high < 0 || low > end ? 0 : low < 0 ? -low : Math.min(0, end - high));
    const [x, y] = [shift(box.left, box.right, width), shift(box.top, box.bottom, height)];
    return { left: box.left + x, right: box.right + x, top: box.top + y, bottom: box.bottom + y };
  }

  // The order in which names are placed: bodies of solids the nearest first, the others in their order.
  order() {
    const eye = this.stage.camera.getWorldDirection(new THREE.Vector3());
    const depth = this.stage.bodies.map((body, i) => (this.boxes[i] ? body.getWorldPosition(new THREE.Vector3()).dot(eye) : -Infinity));
    return this.stage.bodies.map((_, i) => i).sort((a, b) => (depth[a] === depth[b] ? a - b : depth[a] - depth[b]));
  }
}

// Whether a box, in pixels, overlaps none of the occupied ones.
function isFree(box, occupied) {
  return occupied.every((b) => box.right < b.left || box.left > b.right || box.bottom < b.top || box.top > b.bottom);
}

// Whether a line comes nearer to a box than a distance, in pixels; its ends, as long as that, do not count.
function crosses(box, [[x0, y0], [x1, y1]], near) {
  const end = near / Math.hypot(x1 - x0, y1 - y0);
  let [first, last] = [end, 1 - end]; // the part of the line that is within the sides so far
  for (const [start, end, low, high] of [[x0, x1, box.left - near, box.right + near], [y0, y1, box.top - near, box.bottom + near]]) {
    if (start === end && (start < low || start > high)) return false;
    if (start === end) continue;
    const [one, other] = [(low - start) / (end - start), (high - start) / (end - start)];
    first = Math.max(first, Math.min(one, other));
    last = Math.min(last, Math.max(one, other));
  }
  return first <= last;
}

// The opaque meshes of an object.
function opaque(object) {
  const meshes = [];
  object.traverse((mesh) => mesh.isMesh && !mesh.material.transparent && meshes.push(mesh));
  return meshes;
}

// Where a ray meets meshes, the nearest first, as intersectObjects of three.js; but only the triangles of parts are tried whose
// box the ray meets.
function hitsOf(caster, meshes) {
  const hits = [];
  for (const mesh of meshes) {
    const ray = caster.ray.clone().applyMatrix4(mesh.matrixWorld.clone().invert());
    for (const { box, start } of partsOf(mesh.geometry)) {
      if (!ray.intersectsBox(box)) continue;
      mesh.geometry.setDrawRange(start, partSize);
      mesh.raycast(caster, hits);
    }
    mesh.geometry.setDrawRange(0, Infinity);
  }
  return hits.sort((a, b) => a.distance - b.distance);
}

const partSize = 3 * 64; // corners of successive triangles, which are near to each other in most meshes

// The parts of a mesh with boxes around them, computed once.
function partsOf({ userData, index, attributes: { position } }) {
  if (userData.parts) return userData.parts;
  const count = (index || position).count;
  const corner = new THREE.Vector3();
  userData.parts = Array.from({ length: Math.ceil(count / partSize) }, (_, part) => {
    const [box, start] = [new THREE.Box3(), part * partSize];
    for (let i = start; i < Math.min(start + partSize, count); i++) {
      box.expandByPoint(corner.fromBufferAttribute(position, index ? index.getX(i) : i));
    }
    return { box: box, start: start };
  });
  return userData.parts;
}

// The middle of a box given by its corners, and two points on either side of it where the box is longest.
function pointsAlong(corners) {
  const [low, high] = [corners[0], corners[7]];
  const size = high.clone().sub(low);
  const axis = ["x", "y", "z"].reduce((best, name) => (size[name] > size[best] ? name : best));
  return [-1, 0, 1].map((side) => {
    const point = low.clone().add(high).multiplyScalar(0.5);
    point[axis] += (side * size[axis]) / 3;
    return point;
  });
}

// The corners of a box around the largest child of an object, in its own frame.
function boxAround(object) {
  const boxes = object.children.map((child) => new THREE.Box3().setFromObject(child));
  const point = new THREE.Box3(new THREE.Vector3(), new THREE.Vector3());
  const size = ({ min, max }) => min.distanceTo(max);
  const { min, max } = boxes.reduce((best, box) => (size(box) > size(best) ? box : best), point);
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new THREE.Vector3(x, y, z))));
}
