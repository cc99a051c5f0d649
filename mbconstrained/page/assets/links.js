// Links: one class per kind. Each has an object and an update(from, to) that is called at every frame with the poses
// {position: Vector3, angle: turn about the y axis} of its two ends; nothing about a link is stored per key frame.

const along = () => new THREE.Vector3(1, 0, 0);

// Places an object whose own x axis is the link from one point to another; returns their distance.
function lay(object, from, to) {
  const direction = to.clone().sub(from);
  const length = direction.length();
  object.position.copy(from);
  if (length > 0) object.quaternion.setFromUnitVectors(along(), direction.divideScalar(length));
  return length;
}

// A cylinder of unit length along x; its scale along x is its length.
function bar(radius, color, options) {
  const geometry = new THREE.CylinderGeometry(radius, radius, 1, 20, 1, Boolean(options && options.open));
  geometry.rotateZ(Math.PI / 2);
  geometry.translate(0.5, 0, 0);
  return solid(geometry, color, options && options.material);
}

function stretch(part, start, end) {
  part.position.x = start;
  part.scale.x = Math.max(end - start, 1e-6);
}

// A round wire along a curve that changes shape: the wire's section stays round however far it is bent.
class Wire {
  constructor(rings, radius, color) {
    this.sides = detail.coarse ? 4 : 8;
    this.rings = detail.coarse ? Math.ceil(rings / 2.5) : rings;
    this.radius = radius;
    const geometry = new THREE.BufferGeometry();
    const room = () => new THREE.BufferAttribute(new Float32Array(3 * (this.rings + 1) * this.sides), 3);
    geometry.setAttribute("position", room());
    geometry.setAttribute("normal", room());
    geometry.setIndex(this.faces());
    this.object = solid(geometry, color, { shininess: 60 });
    this.object.frustumCulled = false;
    const vectors = () => Array.from({ length: this.rings + 1 }, () => new THREE.Vector3());
    [this.points, this.normals] = [vectors(), vectors()];
  }

  faces() {
    const index = [];
    for (let ring = 0; ring < this.rings; ring++) {
      for (let side = 0; side < this.sides; side++) {
        const [a, b] = [ring * this.sides + side, ring * this.sides + ((side + 1) % this.sides)];
        index.push(a, b, a + this.sides, b, b + this.sides, a + this.sides);
      }
    }
    return index;
  }

  // curve(s, point, normal) fills a point at 0 <= s <= 1 and a direction across the wire there.
  follow(curve) {
    const { points, normals } = this;
    for (let ring = 0; ring <= this.rings; ring++) curve(ring / this.rings, points[ring].set(0, 0, 0), normals[ring]);
    const { position, normal } = this.object.geometry.attributes;
    const [tangent, side, out] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    for (let ring = 0, vertex = 0; ring <= this.rings; ring++) {
      tangent.subVectors(points[Math.min(ring + 1, this.rings)], points[Math.max(ring - 1, 0)]).normalize();
      normals[ring].addScaledVector(tangent, -normals[ring].dot(tangent)).normalize();
      side.crossVectors(tangent, normals[ring]);
      for (let k = 0; k < this.sides; k++, vertex++) {
        const angle = (2 * Math.PI * k) / this.sides;
        out.copy(normals[ring]).multiplyScalar(Math.cos(angle)).addScaledVector(side, Math.sin(angle));
        normal.setXYZ(vertex, out.x, out.y, out.z);
        out.multiplyScalar(this.radius).add(points[ring]);
        position.setXYZ(vertex, out.x, out.y, out.z);
      }
    }
    position.needsUpdate = true;
    normal.needsUpdate = true;
  }
}

const ramp = (s, start, end) => Math.min(1, Math.max(0, (s - start) / (end - start)));

class Spring {
  constructor(reach, radius = 0.13) {
    this.radius = radius;
    this.turns = Math.round(Math.min(24, Math.max(6, 7 * reach.mean)));
    this.wire = new Wire(this.turns * 18, 0.026, "#5a6b7b");
    this.object = this.wire.object;
    this.drawn = NaN; // the length for which the wire was drawn
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const stretched = length / this.drawn;
    const near = detail.coarse && stretched > 0.6 && stretched < 1.6; // with many springs the wires may be slightly elliptic
    this.object.scale.x = near ? stretched : 1;
    if (near) return;
    this.drawn = length;
    const lead = Math.min(0.12, 0.15 * length);
    this.wire.follow((s, point, normal) => {
      const coil = ramp(s, 0.06, 0.94);
      const angle = 2 * Math.PI * this.turns * coil;
      const radius = this.radius * Math.min(ramp(s, 0.04, 0.07), ramp(1 - s, 0.04, 0.07));
      const x = lead * ramp(s, 0, 0.06) + (length - 2 * lead) * coil + lead * ramp(s, 0.94, 1);
      normal.set(0, Math.cos(angle), Math.sin(angle));
      point.copy(normal).multiplyScalar(radius);
      point.x = x;
    });
  }
}

class Damper {
  // The cylinder is as long as the stroke needs, and no longer than the shortest length of the damper allows.
  constructor(reach) {
    const stroke = reach.longest - reach.shortest;
    this.lead = Math.min(0.15, 0.15 * reach.shortest);
    this.cylinder = Math.min(Math.max(1.15 * stroke, 0.42 * reach.mean), 0.78 * reach.shortest);
    this.rod = (reach.longest + reach.shortest) / 2 - this.lead - this.cylinder / 2;
    const glass = { transparent: true, opacity: 0.38, side: THREE.DoubleSide, depthWrite: false };
    this.parts = {
      lead: bar(0.03, ink),
      cap: bar(0.135, ink),
      glass: bar(0.135, "#a9bccb", { open: true, material: glass }),
      piston: bar(0.115, "#c8553d"),
      rod: bar(0.03, ink),
    };
    this.parts.glass.castShadow = false;
    this.object = group(...Object.values(this.parts));
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const [low, high] = [this.lead + 0.05, this.lead + this.cylinder - 0.05];
    const head = Math.min(Math.max(length - this.rod, low), Math.max(low, high));
    stretch(this.parts.lead, 0, this.lead);
    stretch(this.parts.cap, this.lead - 0.02, this.lead + 0.02);
    stretch(this.parts.glass, this.lead, this.lead + this.cylinder);
    stretch(this.parts.piston, head - 0.03, head + 0.03);
    stretch(this.parts.rod, head, length);
  }
}

// A spring around a damper, as in a suspension.
class Strut {
  constructor(reach) {
    this.spring = new Spring(reach, 0.2);
    this.damper = new Damper(reach);
    this.object = group(this.spring.object, this.damper.object);
  }

  update(from, to) {
    this.spring.update(from, to);
    this.damper.update(from, to);
  }
}

// Drawn over the body around it, which would hide it.
function overlay(geometry, color, opacity, order) {
  const mesh = solid(geometry, color, { depthTest: false, transparent: true, opacity: opacity });
  mesh.castShadow = false;
  mesh.receiveShadow = false;
  mesh.renderOrder = order;
  return mesh;
}

// A joint that closes a loop: a ball on one body in a socket on the other, and a bar across any gap between them.
class Loop {
  constructor() {
    this.socket = overlay(new THREE.SphereGeometry(0.12, 32, 20), "#ffffff", 0.55, 10);
    this.gap = bar(0.02, "#d1344b");
    this.ball = overlay(new THREE.SphereGeometry(0.065, 32, 20), ink, 1, 12);
    this.object = group(this.socket, this.gap, this.ball);
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    stretch(this.gap, 0, length);
    this.ball.position.x = length;
  }
}

// A soft block between two bodies: from point to point, and round where these coincide. Bodies in front of it hide it.
class Bushing {
  constructor() {
    this.object = group(solid(new THREE.SphereGeometry(0.15, 32, 20), "#e0a458"));
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const [block] = this.object.children;
    block.position.x = length / 2;
    block.scale.x = 1 + length / 0.3;
  }
}

class Rod {
  constructor() {
    this.bar = bar(0.045, ink);
    this.object = group(this.bar);
  }

  update(from, to) {
    stretch(this.bar, 0, lay(this.object, from.position, to.position));
  }
}

// Between two wheels on one axis: a helix that winds with their angles. Around one wheel, or next to it: a flat spiral
// from its fixed end to the hub.
class TorsionSpring {
  constructor(reach) {
    this.turns = 5;
    this.wire = new Wire(this.turns * 26, 0.026, "#5a6b7b");
    this.object = this.wire.object;
    this.coaxial = reach.coaxial;
  }

  update(from, to) {
    if (this.coaxial) this.helix(from, to);
    else this.spiral(from, to);
  }

  helix(from, to) {
    const total = 2 * Math.PI * this.turns + to.angle - from.angle;
    this.object.position.copy(from.position);
    const axis = to.position.clone().sub(from.position);
    this.wire.follow((s, point, normal) => {
      const angle = -from.angle - total * ramp(s, 0.04, 0.96); // a turn about +y is clockwise for the viewer
      const radius = 0.17 * Math.min(ramp(s, 0, 0.04), ramp(1 - s, 0, 0.04));
      normal.set(Math.cos(angle), 0, Math.sin(angle));
      point.copy(axis).multiplyScalar(s).addScaledVector(normal, radius);
    });
  }

  spiral(from, to) {
    const arm = from.position.clone().sub(to.position);
    const [outer, start] = [Math.hypot(arm.x, arm.z), Math.atan2(arm.z, arm.x)];
    const total = 2 * Math.PI * this.turns - (to.angle - from.angle);
    this.object.position.copy(to.position);
    this.wire.follow((s, point, normal) => {
      const angle = start + total * s;
      normal.set(Math.cos(angle), 0, Math.sin(angle));
      point.copy(normal).multiplyScalar(outer + (0.12 * outer - outer) * s);
      point.y = arm.y;
    });
  }
}

// Between two wheels on one axis: a drum that turns with the first around a vane that turns with the second. Next to a
// wheel: a brake shoe on its rim.
class TorsionDamper {
  constructor(reach) {
    this.coaxial = reach.coaxial;
    const glass = { transparent: true, opacity: 0.38, side: THREE.DoubleSide, depthWrite: false };
    this.drum = bar(0.2, "#a9bccb", { open: true, material: glass });
    this.vane = solid(new THREE.BoxGeometry(0.22, 0.34, 0.06), "#c8553d");
    this.shaft = bar(0.035, ink);
    this.shoe = solid(new THREE.BoxGeometry(0.16, 0.3, 0.26), "#c8553d");
    this.object = reach.coaxial ? group(this.drum, this.vane, this.shaft) : group(this.shoe, this.shaft);
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    if (!this.coaxial) {
      this.shoe.position.x = length - 0.08;
      stretch(this.shaft, 0, length);
      return;
    }
    stretch(this.drum, 0.3 * length, 0.7 * length);
    stretch(this.shaft, 0, length);
    this.vane.position.x = length / 2;
    this.vane.rotation.x = to.angle;
  }
}

// A rope from the start up to the wheel it runs over, around its top, and down to the end.
class Belt {
  constructor(reach) {
    this.radius = reach.radius;
    this.wire = new Wire(48, 0.022, "#7a5230");
    this.object = this.wire.object;
  }

  update(from, to, over) {
    const middle = over ? over.position : from.position.clone().lerp(to.position, 0.5);
    const corner = (side) => middle.clone().add(new THREE.Vector3(side * this.radius, 0, 0));
    this.wire.follow((s, point, normal) => {
      const angle = Math.PI * (1 - ramp(s, 0.1, 0.9));
      normal.set(Math.cos(angle), 0, Math.sin(angle));
      if (s < 0.1) point.lerpVectors(from.position, corner(-1), s / 0.1);
      else if (s > 0.9) point.lerpVectors(corner(1), to.position, (s - 0.9) / 0.1);
      else point.copy(middle).addScaledVector(normal, this.radius);
    });
  }
}

// Links with several states. A rod of the start ends in a plate, which the end's body strikes at the limit of the length.
class Stop {
  constructor({ limits }) {
    this.limits = limits;
    this.rods = limits.map((limit) => limit !== null && bar(0.05, steel)).filter(Boolean);
    this.plates = this.rods.map(() => plateOf(0.06, 0.34));
    this.collar = bar(0.1, steel);
    this.object = group(...this.rods, ...this.plates, this.collar);
    this.lit = this.plates;
  }

  update(from, to) {
    const [low, high] = this.limits;
    const length = lay(this.object, from.position, to.position);
    const tips = [low !== null && Math.min(low, length) - 0.03, high !== null && Math.max(high, length) + 0.09].filter((tip) => tip !== false);
    tips.forEach((tip, i) => {
      stretch(this.rods[i], 0, tip);
      this.plates[i].position.x = tip;
    });
    this.collar.visible = high !== null;
    stretch(this.collar, length, length + 0.06);
  }
}

// A tongue of the end's body between two plates of the start's, a distance back from the end.
class Slot {
  constructor({ limits, shortest }) {
    this.limits = limits;
    this.back = 0.5 * shortest;
    [this.rod, this.rail, this.arm] = [bar(0.05, steel), bar(0.025, steel), bar(0.045, ink)];
    this.plates = [plateOf(0.06, 0.4), plateOf(0.06, 0.4)];
    this.tongue = plateOf(0.08, 0.26);
    this.lit = [...this.plates, this.tongue];
    this.object = group(this.rod, this.rail, this.arm, ...this.lit);
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const [near, far] = [this.limits[0] - this.back - 0.07, this.limits[1] - this.back + 0.07];
    stretch(this.rod, 0, near);
    stretch(this.rail, near, far);
    this.rail.position.z = -0.17;
    this.plates.forEach((each, i) => (each.position.x = [near, far][i]));
    this.tongue.position.x = length - this.back;
    stretch(this.arm, length - this.back, length);
  }
}

// A line of constant length that hangs to the side while it is slack: half a wave of a sine, whose length is nearly that of a circular arc.
class Cable {
  constructor({ limits }) {
    this.long = Math.max(...limits.filter((limit) => limit !== null));
    this.wire = new Wire(32, 0.03, steel);
    this.object = this.wire.object;
    this.lit = [this.object];
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const slack = Math.max(this.long / Math.max(length, 1e-6), 1);
    const height = Math.min((2 * length * Math.sqrt(slack - 1)) / Math.PI, this.long / 2);
    this.wire.follow((s, point, normal) => {
      normal.set(0, 1, 0);
      point.set(length * s, 0, height * Math.sin(Math.PI * s));
    });
  }
}

// A strip with notches that moves with the start, and a pad of the end's body on it.
class Friction {
  constructor({ shortest, longest }) {
    this.strip = solid(new THREE.BoxGeometry(1, 0.2, 0.05).translate(0.5, 0, 0), steel);
    this.notches = Array.from({ length: Math.min(40, Math.floor(longest / 0.2)) }, () => plateOf(0.03, 0.24, 0.06));
    this.pad = plateOf(0.34, 0.2, 0.12);
    this.arm = bar(0.04, ink);
    this.back = 0.5 * Math.max(shortest, 0.4);
    this.object = group(this.strip, this.pad, this.arm, ...this.notches);
    this.lit = [this.pad];
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    stretch(this.strip, 0, length - 0.1);
    this.notches.forEach((notch, i) => {
      notch.position.x = 0.2 * (i + 0.5);
      notch.visible = notch.position.x < length - 0.12;
    });
    this.pad.position.set(length - this.back, 0, 0.08);
    stretch(this.arm, length - this.back, length);
    this.arm.position.z = 0.1;
  }
}

// The pad between a body and the support below it, fixed to the body.
class Pad {
  constructor() {
    this.pad = solid(new THREE.BoxGeometry(0.6, 0.6, 0.1), steel);
    this.object = group(this.pad);
    this.lit = [this.pad];
  }

  update(from, to) {
    this.object.position.copy(to.position).z -= 0.05;
  }
}

// A hook of the start that holds a pin of the end's body from the length at which it closes.
class Latch {
  constructor({ limits, mean }) {
    this.long = limits[0] === null ? mean : limits[0];
    [this.rod, this.arm] = [bar(0.05, steel), bar(0.05, steel)];
    this.hook = solid(new THREE.TorusGeometry(0.12, 0.035, 10, 24, Math.PI * 1.4), steel);
    this.pin = solid(new THREE.SphereGeometry(0.08, 24, 16), steel);
    this.object = group(this.rod, this.arm, this.hook, this.pin);
    this.lit = [this.hook, this.pin];
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const half = this.long / 2;
    stretch(this.rod, 0, half - 0.12);
    stretch(this.arm, length - half, length);
    this.hook.position.x = half;
    this.hook.rotation.set(Math.PI / 2, 0, Math.PI * 0.3);
    this.pin.position.x = length - half;
  }
}

// Between bodies that turn: a tongue of the end's body between fingers of the start's, at the angles at which they touch.
class Play {
  constructor({ limits, magnification, coaxial }) {
    Object.assign(this, { limits: limits, magnification: magnification, coaxial: coaxial });
    const arm = (length) => solid(new THREE.BoxGeometry(length, 0.1, 0.09).translate(length / 2, 0, 0), steel);
    this.fingers = limits.map((limit) => limit !== null && arm(0.5));
    this.tongue = arm(0.42);
    this.shaft = bar(0.035, ink);
    this.lit = [...this.fingers.filter(Boolean), this.tongue];
    this.object = group(...this.lit, this.shaft);
  }

  update(from, to) {
    const [a, b] = [from.position, to.position];
    const middle = this.coaxial ? a.clone().lerp(b, 0.5) : b.clone().setY(a.y);
    const start = this.coaxial ? 0 : Math.atan2(a.x - middle.x, a.z - middle.z) - Math.PI / 2;
    this.object.position.copy(middle);
    const width = 0.2; // of a finger as an angle, so that their faces touch and not their middles
    this.fingers.forEach((finger, i) => {
      if (!finger) return;
      const limit = this.magnification * this.limits[i];
      finger.rotation.y = start + from.angle + limit + Math.sign(limit || 2 * i - 1) * width;
    });
    this.tongue.rotation.y = start + from.angle + this.magnification * (to.angle - from.angle);
    this.shaft.quaternion.setFromUnitVectors(along(), new THREE.Vector3(0, 1, 0));
    const reach = this.coaxial ? a.distanceTo(b) / 2 : 0.1;
    stretch(this.shaft, 0, 2 * reach);
    this.shaft.position.set(0, -reach, 0);
  }
}

// Two discs on one axis, each with a mark that turns with its body; they touch while they transmit a torque.
class Clutch {
  constructor() {
    this.discs = [0, 1].map(() => bar(0.32, steel));
    this.marks = this.discs.map(() => solid(new THREE.BoxGeometry(0.3, 0.07, 0.07).translate(0.2, 0, 0), ink));
    this.shafts = [0, 1].map(() => bar(0.05, ink));
    this.object = group(...this.discs, ...this.marks, ...this.shafts);
    this.lit = this.discs;
    this.level = 0;
  }

  update(from, to) {
    const length = lay(this.object, from.position, to.position);
    const apart = this.level ? 0.005 : 0.06;
    const faces = [length / 2 - apart, length / 2 + apart];
    stretch(this.discs[0], faces[0] - 0.09, faces[0]);
    stretch(this.discs[1], faces[1], faces[1] + 0.09);
    stretch(this.shafts[0], 0, faces[0]);
    stretch(this.shafts[1], faces[1], length);
    [from, to].forEach(({ angle }, i) => {
      this.marks[i].position.x = faces[i] + (i ? 0.07 : -0.07);
      this.marks[i].rotation.set(angle, 0, Math.PI / 2);
    });
  }
}

// A shoe on the rim of a wheel, or two discs where it is on the axis.
class Brake extends TorsionDamper {
  constructor(reach) {
    super(reach);
    this.lit = [reach.coaxial ? this.vane : this.shoe];
  }
}

function plateOf(thickness, height, depth = height) {
  return solid(new THREE.BoxGeometry(thickness, height, depth), steel);
}

// Colours of parts by their engagement: without force, slipping, and closed, stuck or taut; without states their own.
const engagementColors = ["#a9b4bf", "#f0c808", "#e8590c"];

// The engagement of a link at a time, or -1.
function engagementAt({ states }, time) {
  if (!states) return -1;
  const { begins, levels } = states;
  let level = levels[0];
  for (let i = 1; i < begins.length && begins[i] <= time; i++) level = levels[i];
  return level;
}

function showEngagement(drawn, level) {
  const parts = drawn.lit || [];
  if (!parts.length) drawn.object.traverse((part) => part.material && parts.push(part));
  for (const { material } of parts) {
    material.color.set(engagementColors[level]);
    if (material.emissive) material.emissive.set(level ? engagementColors[level] : "#000000").multiplyScalar(0.15);
    Object.assign(material, { transparent: level === 0, opacity: level === 0 ? 0.65 : 1 });
  }
}

const kinds = {
  spring: Spring,
  damper: Damper,
  strut: Strut,
  rod: Rod,
  bushing: Bushing,
  loop: Loop,
  "torsion spring": TorsionSpring,
  "torsion damper": TorsionDamper,
  belt: Belt,
  stop: Stop,
  slot: Slot,
  cable: Cable,
  friction: Friction,
  pad: Pad,
  latch: Latch,
  play: Play,
  clutch: Clutch,
  brake: Brake,
};
