// The overlay of the model: arrows of forces, and for a while after a jump or an impulse faint bodies at their positions
// before, arrows of the impulses, and a list of what changed.

const eventDuration = { share: 0.04, seconds: 1.5 }; // at least this share of the motion, and this time as it plays
const arrowColors = { force: "#b0306a", impulse: "#d1344b" };

const labelShifts = [0, 16, 32]; // px, of the label of an arrow that would cover another one
const leastBend = Math.PI / 6; // rad, of the arrow of a moment: a shorter one is a head without a shaft

// An arrow that is never hidden by the model; along a direction, or around it for a moment.
class Arrow {
  constructor(stage, { turns }, kind, path) {
    const color = arrowColors[kind];
    this.stage = stage;
    this.turns = turns;
    this.shaft = overlay(turns ? new THREE.BufferGeometry() : bar(0.035, color).geometry, color, 0.92, 20);
    this.head = overlay(new THREE.ConeGeometry(0.1, 0.24, 24).translate(0, 0.12, 0).rotateZ(-Math.PI / 2), color, 0.92, 20);
    this.object = stage.place(path, group(this.shaft, this.head));
    this.label = stage.names.label("");
    this.label.classList.add(kind);
  }

  // From a point, as a vector, both in drawing units.
  show(point, vector, text, opacity = 1) {
    const length = vector.length();
    const visible = length > 0.02 && opacity > 0;
    this.object.visible = visible;
    this.label.textContent = visible ? text : "";
    if (!visible) return;
    this.object.position.copy(point);
    this.object.quaternion.setFromUnitVectors(this.turns ? new THREE.Vector3(0, 0, 1) : along(), vector.clone().normalize());
    if (this.turns) this.bend(length);
    else this.reach(length);
    for (const part of [this.shaft, this.head]) part.material.opacity = 0.92 * opacity;
    this.label.style.opacity = opacity;
  }

  reach(length) {
    const tip = Math.min(0.24, 0.6 * length);
    stretch(this.shaft, 0, length - tip);
    this.head.position.set(length - tip, 0, 0);
    this.head.scale.setScalar(tip / 0.24);
  }

  // Three quarters of a circle at the longest.
  bend(length) {
    const angle = Math.max(leastBend, length * Math.PI);
    this.shaft.geometry.dispose();
    this.shaft.geometry = new THREE.TorusGeometry(0.62, 0.035, 8, 40, angle);
    this.head.position.set(0.62 * Math.cos(angle), 0.62 * Math.sin(angle), 0);
    this.head.rotation.z = angle + Math.PI / 2;
  }

  // Places the label at the tip of the arrow, or a line or two further on, unless it would cover another one.
  placeLabel(occupied) {
    const [[left, level], [, foot]] = [this.head, this.object].map((part) => this.stage.pixels(part.getWorldPosition(new THREE.Vector3())));
    const upwards = !this.turns && level < foot - 2;
    const half = 3.5 * this.label.textContent.length + 3; // an estimate: measuring it in each frame would be slow
    const tops = labelShifts.map((shift) => level + (upwards ? -32 - shift : 12 + shift));
    const boxes = tops.map((top) => ({ left: left - half, right: left + half, top: top, bottom: top + 15 }));
    const free = boxes.find((box) => isFree(box, occupied));
    this.label.style.visibility = free ? "visible" : "hidden";
    if (!free) return;
    this.label.style.transform = `translate(-50%, 0) translate(${left}px, ${free.top}px)`;
    occupied.push(free);
  }
}

// Forces, shown all the time; their values are further coordinates of the motion, after those of the model.
class Forces {
  constructor(stage, forces) {
    this.forces = forces;
    this.arrows = forces.map(({ arrows }, i) =>
      arrows.map((arrow, k) => new Arrow(stage, arrow, "force", ["overlay", `force ${i} ${k}`]))
    );
  }

  show(frames, coordinates) {
    let first = coordinates.length - this.forces.reduce((count, { rows }) => count + rows, 0);
    this.forces.forEach(({ arrows, rows }, i) => {
      const value = coordinates.slice(first, (first += rows));
      arrows.forEach((arrow, k) => {
        const vector = frames.vector(arrow, value).multiplyScalar(arrow.factor);
        const label = withUnit(vector.length(), arrow.unit);
        this.arrows[i][k].show(frames.point(arrow), vector.multiplyScalar(arrow.length), label);
      });
    });
  }

  get all() {
    return this.arrows.flat();
  }
}

const withUnit = (size, unit) => numberWithUnit(threeDigits(Math.abs(size)), unit);

function threeDigits(size) {
  if (size === 0 || (size >= 1e-4 && size < 1e5)) return String(Number(size.toPrecision(3)));
  const [factor, power] = size.toExponential(2).split("e").map(Number);
  return decimalText(Math.round(100 * factor), power - 2, 0);
}

// Jumps and impulses, each shown for a while after its time.
class Events {
  constructor(stage, events) {
    this.stage = stage;
    this.events = events;
    this.shown = -1;
    this.age = 1;
    this.drawn = events.map(() => null); // objects, created when they are first shown
    this.lists = events.map(({ lines }) => this.listOf(lines));
    const strip = document.createElement("div");
    strip.className = "events";
    strip.append(...this.lists);
    stage.pane.after(strip); // below the model, as high as the longest list, so that nothing is hidden and nothing moves
  }

  listOf(lines) {
    const list = document.createElement("p");
    list.className = "event";
    list.textContent = lines.join("\n");
    return list;
  }

  show(frames, coordinates, time, motion) {
    const shown = this.at(time, motion);
    if (shown !== this.shown) this.change(shown);
    if (shown < 0) return;
    const { ghosts, arrows } = this.drawn[shown];
    const opacity = Math.min(1, 2 - 2 * this.age);
    for (const ghost of ghosts) ghost.material.opacity = 0.3 * opacity;
    this.events[shown].impulses.forEach((impulse, k) => {
      const vector = frames.vector(impulse, [impulse.size].flat()).multiplyScalar(impulse.length);
      arrows[k].show(frames.point(impulse), vector, impulse.label, opacity);
    });
    this.lists[shown].style.opacity = opacity;
  }

  // The last event that is still shown, or -1; its age is 0 at its time and 1 when it disappears.
  at(time, motion) {
    const duration = Math.max(eventDuration.share * (motion.end - motion.start), eventDuration.seconds * Number(control("speed").value));
    const last = this.events.reduce((best, event, i) => (event.time <= time + 1e-12 * Math.abs(time) ? i : best), -1);
    this.age = last < 0 ? 1 : (time - this.events[last].time) / duration;
    return this.age < 1 ? last : -1;
  }

  change(shown) {
    if (this.shown >= 0) this.hide(this.drawn[this.shown]);
    this.shown = shown;
    this.lists.forEach((list, i) => list.classList.toggle("shown", i === shown));
    if (this.stage.pane.clientHeight !== this.stage.size[1]) this.stage.fit(); // in a still picture the height follows the list
    if (shown < 0) return;
    this.drawn[shown] = this.drawn[shown] || this.draw(shown);
    this.drawn[shown].object.visible = true;
  }

  hide({ object, arrows }) {
    object.visible = false;
    for (const arrow of arrows) arrow.show(null, new THREE.Vector3(), "");
  }

  draw(number) {
    const { ghosts, impulses } = this.events[number];
    const bodies = ghosts.map(([body, ...pose]) => this.ghost(body, pose));
    const object = this.stage.place(["bodies", `before ${number}`], group(...bodies));
    const arrows = impulses.map((impulse, k) => new Arrow(this.stage, impulse, "impulse", ["overlay", `impulse ${number} ${k}`]));
    const meshes = [];
    object.traverse((mesh) => mesh.material && meshes.push(mesh));
    return { object: object, ghosts: meshes, arrows: arrows };
  }

  ghost(number, pose) {
    const faint = this.stage.bodies[number].clone();
    faint.position.set(...pose.slice(0, 3));
    faint.quaternion.set(...pose.slice(3));
    faint.traverse((part) => {
      if (!part.material) return;
      part.material = Object.assign(part.material.clone(), { transparent: true, depthWrite: false });
      if (part.material.color.getHSL({}).l > 0.8) part.material.color.lerp(new THREE.Color(ink), 0.6); // white would be invisible
      part.castShadow = part.receiveShadow = false;
    });
    return faint;
  }

  get all() {
    return this.drawn.flatMap((drawn) => (drawn ? drawn.arrows : []));
  }
}

// Forces and events on a stage.
class Overlay {
  constructor(stage, { forces, events }) {
    this.stage = stage;
    this.layers = [...(forces.length ? [new Forces(stage, forces)] : []), ...(events.length ? [new Events(stage, events)] : [])];
  }

  show(poses, coordinates, time, motion) {
    const frames = {
      point: (arrow) => this.point(poses[arrow.body], arrow),
      vector: (arrow, value) => vectorOf(poses[arrow.body], arrow, value),
    };
    for (const layer of this.layers) layer.show(frames, coordinates, time, motion);
  }

  // Where an arrow begins, in drawing units.
  point(pose, { point }) {
    return turned(pose, point).add(new THREE.Vector3(...pose.position)).divideScalar(this.stage.figure.unit);
  }

  // Places all labels, those of impulses first, and adds their boxes, in pixels, to the occupied ones.
  placeLabels(occupied) {
    for (const layer of this.layers.slice().reverse()) {
      for (const arrow of layer.all) if (arrow.label.textContent) arrow.placeLabel(occupied);
    }
  }
}

// One component along the direction of the arrow, or three in the frame of its body.
function vectorOf(pose, { direction }, value) {
  return direction ? new THREE.Vector3(...direction).multiplyScalar(value[0]) : turned(pose, value);
}

function turned({ quaternion }, numbers) {
  return new THREE.Vector3(...numbers).applyQuaternion(new THREE.Quaternion(...quaternion));
}
