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
  constructor(rings, radius, color, sides = detail.coarse ? 4 : 8) {
    this.sides = sides;
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

const glass = { transparent: true, opacity: 0.38, side: THREE && THREE.DoubleSide, depthWrite: false };

class Damper {
  // The cylinder is as long as the stroke needs, and no longer than the shortest length of the damper allows.
  constructor(reach) {
    const stroke = reach.longest - reach.shortest;
    this.lead = Math.min(0.15, 0.15 * reach.shortest);
    this.cylinder = Math.min(Math.max(1.15 * stroke, 0.42 * reach.mean), 0.78 * reach.shortest);
    this.rod = (reach.longest + reach.shortest) / 2 - this.lead - this.cylinder / 2;
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
};
