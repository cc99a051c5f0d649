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
  }

  // Above the middle of a body, at the height of its highest edge, in pixels.
  top(i) {
    if (this.boxes[i]) return this.onSolid(i);
    const { shape, size, rest_turn } = this.drawn[i];
    const turn = this.stage.turn.clone().multiply(quaternionOf(rest_turn));
    const middle = this.stage.bodies[i].getWorldPosition(new THREE.Vector3()); // in axes with y up
    const { x, y } = middle.clone().project(this.stage.camera);
    const reach = (...axis) => {
      const [along, back, upwards] = new THREE.Vector3(...axis).applyQuaternion(turn).toArray();
      return middle.clone().add(new THREE.Vector3(along, upwards, -back)).project(this.stage.camera).y - y;
    };
    const [across, away, up] = [(size[0] / 2) * reach(1, 0, 0), (size[1] / 2) * reach(0, 1, 0), (size[2] / 2) * reach(0, 0, 1)];
    const face = wheels[shape] ? wheels[shape] * Math.hypot(across, up) : Math.abs(across) + Math.abs(up);
    const [width, height] = this.stage.size;
    return [((x + 1) / 2) * width, ((1 - (y + face + Math.abs(away))) / 2) * height];
  }

  // On the middle of the largest solid of a body, or just above it where that is flat.
  onSolid(i) {
    const [width, height] = this.stage.size;
    const projected = this.boxes[i].map((corner) => this.stage.bodies[i].localToWorld(corner.clone()).project(this.stage.camera));
    const [xs, ys] = [projected.map(({ x }) => ((x + 1) / 2) * width), projected.map(({ y }) => ((1 - y) / 2) * height)];
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
      const [first] = caster.intersectObjects(solids.flat(), false);
      return Boolean(first) && !own(i, first) && first.distance < caster.ray.origin.distanceTo(point);
    };
    const hidden = (i) => pointsAlong(this.boxes[i]).every((point) => covered(i, this.stage.bodies[i].localToWorld(point)));
    return this.drawn.map(({ label }, i) => Boolean(this.boxes[i] && label) && hidden(i));
  }

  // Places the names a little above their bodies; a name that would cover another one or an occupied box,
  // or belongs to a hidden body, is left out.
  place(occupied) {
    this.hidden = this.hidden || this.behind();
    this.sizes = this.sizes || this.labels.map(({ offsetWidth, offsetHeight }) => [offsetWidth, offsetHeight]);
    for (const i of this.order()) {
      const [label, [x, top], [width, height]] = [this.labels[i], this.top(i), this.sizes[i]];
      const y = top - 4;
      label.style.transform = `translate(-50%, -100%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      const box = { left: x - width / 2, right: x + width / 2, top: y - height, bottom: y };
      const shown = isFree(box, occupied) && !this.hidden[i];
      label.style.visibility = shown ? "visible" : "hidden";
      if (shown && label.textContent) occupied.push(box);
    }
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

// The opaque meshes of an object.
function opaque(object) {
  const meshes = [];
  object.traverse((mesh) => mesh.isMesh && !mesh.material.transparent && meshes.push(mesh));
  return meshes;
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
