// Links with several states, and the colours of these; included where a figure has one.

// A rod of the start ends in a plate, which the end's body meets at the limit of the length.
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

// The engagement of a link at a time.
function engagementAt(states, time) {
  states.times = states.times || unpack(states.begins, Float64Array);
  return states.levels[lastBefore(states.times, time)];
}

// Shows an engagement of a link that has another, or any.
function showEngagement(link, level, any = false) {
  if (level === undefined || (level === link.level && !any)) return;
  link.drawn.level = link.level = level;
  const parts = link.drawn.lit || [];
  if (!parts.length) link.drawn.object.traverse((part) => part.material && parts.push(part));
  for (const { material } of parts) {
    material.color.set(engagementColors[level]);
    if (material.emissive) material.emissive.set(level ? engagementColors[level] : "#000000").multiplyScalar(0.15);
    Object.assign(material, { transparent: level === 0, opacity: level === 0 ? 0.65 : 1 });
  }
}

Object.assign(kinds, {
  stop: Stop,
  slot: Slot,
  cable: Cable,
  friction: Friction,
  pad: Pad,
  latch: Latch,
  play: Play,
  clutch: Clutch,
  brake: Brake,
});
