// What is drawn over the model: arrows of forces, and for a while after a jump or an impulse what happened then: faint
// bodies where they were before, arrows of the impulses, and a list.

const afterglow = { share: 0.04, seconds: 1.5 }; // how long a moment is shown: of the whole time, and as it plays
const markColors = { force: "#b0306a", strike: "#d1344b" };

const lines = [0, 16, 32]; // px, by which what is written at an arrow moves out of the way of others
const leastBend = Math.PI / 6; // rad, of the arrow of a moment: a shorter one is a head without a shaft

// An arrow that is drawn over what would hide it; along a direction, or around it for a moment.
class Arrow {
  constructor(stage, { turns }, kind, path) {
    const color = markColors[kind];
    this.stage = stage;
    this.turns = turns;
    this.shaft = overlay(turns ? new THREE.BufferGeometry() : bar(0.035, color).geometry, color, 0.92, 20);
    this.head = overlay(new THREE.ConeGeometry(0.1, 0.24, 24).translate(0, 0.12, 0).rotateZ(-Math.PI / 2), color, 0.92, 20);
    this.object = stage.place(path, group(this.shaft, this.head));
    this.label = stage.names.label("");
    this.label.classList.add(kind);
  }

  // From a place, as a vector, both in drawing units.
  show(place, vector, text, opacity = 1) {
    const length = vector.length();
    const seen = length > 0.02 && opacity > 0;
    this.object.visible = seen;
    this.label.textContent = seen ? text : "";
    if (!seen) return;
    this.object.position.copy(place);
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

  // Writes the size where the arrow points to, or else a line or two further on, unless all that would cover another.
  write(taken) {
    const { x, y } = this.head.getWorldPosition(new THREE.Vector3()).project(this.stage.camera);
    const upwards = !this.turns && y > this.object.getWorldPosition(new THREE.Vector3()).project(this.stage.camera).y + 0.01;
    const [width, height] = this.stage.size;
    const left = ((x + 1) / 2) * width;
    const half = 3.5 * this.label.textContent.length + 3; // near enough: to measure it in each frame would be slow
    const tops = lines.map((away) => ((1 - y) / 2) * height + (upwards ? -32 - away : 12 + away));
    const boxes = tops.map((top) => ({ left: left - half, right: left + half, top: top, bottom: top + 15 }));
    const apart = (a, b) => a.right < b.left || a.left > b.right || a.bottom < b.top || a.top > b.bottom;
    const free = boxes.find((box) => taken.every((b) => apart(box, b)));
    this.label.style.visibility = free ? "visible" : "hidden";
    if (!free) return;
    this.label.style.transform = `translate(-50%, 0) translate(${left}px, ${free.top}px)`;
    taken.push(free);
  }
}

// Forces that are drawn all the time; their values are coordinates of the motion behind those of the model.
class Forces {
  constructor(stage, forces) {
    this.forces = forces;
    this.arrows = forces.map(({ arrows }, i) =>
      arrows.map((arrow, k) => new Arrow(stage, arrow, "force", ["marks", `force ${i} ${k}`]))
    );
  }

  show(frames, coordinates) {
    let first = coordinates.length - this.forces.reduce((count, { rows }) => count + rows, 0);
    this.forces.forEach(({ arrows, rows }, i) => {
      const value = coordinates.slice(first, (first += rows));
      arrows.forEach((arrow, k) => {
        const vector = frames.vector(arrow, value).multiplyScalar(arrow.factor);
        const told = sized(vector.length(), arrow.unit);
        this.arrows[i][k].show(frames.place(arrow), vector.multiplyScalar(arrow.length), told);
      });
    });
  }

  get all() {
    return this.arrows.flat();
  }
}

const sized = (size, unit) => `${String(Number(Math.abs(size).toPrecision(3)))} ${unit}`.trim();

class Moments {
  constructor(stage, moments) {
    this.stage = stage;
    this.moments = moments;
    this.shown = -1;
    this.age = 1;
    this.made = moments.map(() => null); // objects, made when they are first shown
    this.lists = moments.map(({ told }) => this.listOf(told));
    const strip = document.createElement("div");
    strip.className = "moments";
    strip.append(...this.lists);
    stage.pane.after(strip); // below the model, with room for the longest list: nothing is hidden, nothing shifts
  }

  listOf(told) {
    const list = document.createElement("p");
    list.className = "moment";
    list.textContent = told.join("\n");
    return list;
  }

  show(frames, coordinates, time, motion) {
    const shown = this.at(time, motion);
    if (shown !== this.shown) this.change(shown);
    if (shown < 0) return;
    const { ghosts, arrows } = this.made[shown];
    const opacity = Math.min(1, 2 - 2 * this.age);
    for (const part of ghosts) part.material.opacity = 0.3 * opacity;
    this.moments[shown].strikes.forEach((strike, k) => {
      const vector = frames.vector(strike, [strike.size].flat()).multiplyScalar(strike.length);
      arrows[k].show(frames.place(strike), vector, strike.told, opacity);
    });
    this.lists[shown].style.opacity = opacity;
  }

  // The last moment that is not long ago, or -1; its age is 0 at its time and 1 when it is forgotten.
  at(time, motion) {
    const long = Math.max(afterglow.share * (motion.end - motion.start), afterglow.seconds * Number(control("speed").value));
    const last = this.moments.reduce((found, moment, i) => (moment.time <= time + 1e-12 * Math.abs(time) ? i : found), -1);
    this.age = last < 0 ? 1 : (time - this.moments[last].time) / long;
    return this.age < 1 ? last : -1;
  }

  change(shown) {
    if (this.shown >= 0) this.hide(this.made[this.shown]);
    this.shown = shown;
    this.lists.forEach((list, i) => list.classList.toggle("shown", i === shown));
    if (this.stage.pane.clientHeight !== this.stage.size[1]) this.stage.fit(); // a still picture has room for this list only
    if (shown < 0) return;
    this.made[shown] = this.made[shown] || this.make(shown);
    this.made[shown].object.visible = true;
  }

  hide({ object, arrows }) {
    object.visible = false;
    for (const arrow of arrows) arrow.show(null, new THREE.Vector3(), "");
  }

  make(number) {
    const { ghosts, strikes } = this.moments[number];
    const found = ghosts.map(([body, ...pose]) => this.ghost(body, pose));
    const object = this.stage.place(["bodies", `before ${number}`], group(...found));
    const arrows = strikes.map((strike, k) => new Arrow(this.stage, strike, "strike", ["marks", `strike ${number} ${k}`]));
    const parts = [];
    object.traverse((part) => part.material && parts.push(part));
    return { object: object, ghosts: parts, arrows: arrows };
  }

  ghost(number, pose) {
    const faint = this.stage.bodies[number].clone();
    faint.position.set(...pose.slice(0, 3));
    faint.quaternion.set(...pose.slice(3));
    faint.traverse((part) => {
      if (!part.material) return;
      part.material = Object.assign(part.material.clone(), { transparent: true, depthWrite: false });
      if (part.material.color.getHSL({}).l > 0.8) part.material.color.lerp(new THREE.Color(ink), 0.6); // white would not be seen
      part.castShadow = part.receiveShadow = false;
    });
    return faint;
  }

  get all() {
    return this.made.flatMap((made) => (made ? made.arrows : []));
  }
}

// All of them on a stage.
class Marks {
  constructor(stage, { forces, moments }) {
    this.stage = stage;
    this.layers = [...(forces.length ? [new Forces(stage, forces)] : []), ...(moments.length ? [new Moments(stage, moments)] : [])];
  }

  show(poses, coordinates, time, motion) {
    const frames = {
      place: (arrow) => this.place(poses[arrow.body], arrow),
      vector: (arrow, value) => vectorOf(poses[arrow.body], arrow, value),
    };
    for (const layer of this.layers) layer.show(frames, coordinates, time, motion);
  }

  // Where an arrow begins, in drawing units.
  place(pose, { point }) {
    return turned(pose, point).add(new THREE.Vector3(...pose.position)).divideScalar(this.stage.figure.unit);
  }

  // Returns the boxes of what is written, in pixels.
  write() {
    const taken = [];
    for (const layer of this.layers.slice().reverse()) {
      for (const arrow of layer.all) if (arrow.label.textContent) arrow.write(taken); // those of impulses first
    }
    return taken;
  }
}

// One value along the arrow's direction, or three in the frame of its body, with which they turn.
function vectorOf(pose, { direction }, value) {
  return direction ? new THREE.Vector3(...direction).multiplyScalar(value[0]) : turned(pose, value);
}

function turned({ quaternion }, numbers) {
  return new THREE.Vector3(...numbers).applyQuaternion(new THREE.Quaternion(...quaternion));
}
