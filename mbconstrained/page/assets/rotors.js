// Rotors: shafts that bend, and the orbits of their points.

// A shaft through its stations: a beam without load between them. Its slope is that of the body where that tilts, else the mean one
// between the neighbours.
class Shaft {
  constructor({ stations }) {
    this.radius = 0.2;
    this.wire = new Wire(12 * (stations.length - 1), this.radius, steel, 24);
    this.caps = [bar(this.radius, steel), bar(this.radius, steel)];
    this.object = group(this.wire.object, ...this.caps);
  }

  update(from, to, over, stations) {
    const places = stations.map(({ position }) => position);
    const lengths = places.slice(1).map((place, i) => place.distanceTo(places[i]));
    const slopes = stations.map(({ slope }, i) => slope || this.meanSlope(places, Math.max(i - 1, 0), Math.min(i + 1, places.length - 1)));
    const count = lengths.length;
    this.wire.follow((share, point, normal) => {
      const part = Math.min(Math.floor(share * count), count - 1);
      const [s, length] = [share * count - part, lengths[part]];
      const r = 1 - s;
      normal.set(0, 0, 1);
      point.addScaledVector(places[part], r * r * (1 + 2 * s)).addScaledVector(places[part + 1], s * s * (1 + 2 * r));
      point.addScaledVector(slopes[part], length * s * r * r).addScaledVector(slopes[part + 1], -length * s * s * r);
    });
    this.caps.forEach((cap, k) => {
      const [end, sign] = [k ? count : 0, k ? 0.01 : -0.01];
      stretch(cap, 0, lay(cap, places[end], places[end].clone().addScaledVector(slopes[end], sign)));
      cap.position.copy(places[end]);
    });
  }

  meanSlope(places, before, after) {
    return places[after].clone().sub(places[before]).normalize();
  }
}

kinds.shaft = Shaft;

// The paths of points of rotors over the last revolution, or over a whole cycle; seen through the bodies.
const orbitColor = "#e8590c";

class Orbits {
  constructor(stage, { points, window }) {
    Object.assign(this, { stage: stage, window: window });
    this.traces = points.map(([number, point], k) => {
      const { moves, turns } = stage.figure.bodies[number];
      const wire = new Wire(240, 0.026, orbitColor, 6);
      const dot = overlay(new THREE.SphereGeometry(0.065, 16, 12), orbitColor, 1, 9);
      Object.assign(wire.object.material, { depthTest: false, transparent: true });
      Object.assign(wire.object, { castShadow: false, receiveShadow: false, renderOrder: 8 });
      stage.place(["links", `orbit ${k}`], group(wire.object, dot));
      return { number: number, point: point, used: [...moves, ...turns].map(([i]) => i), wire: wire, dot: dot };
    });
  }

  show(motion, time) {
    const [start, end] = this.window === null ? [motion.start, motion.end] : [Math.max(motion.start, time - this.window), time];
    for (const trace of this.traces) {
      trace.wire.follow((share, point, normal) => {
        point.copy(this.place(trace, motion, start + share * (end - start)));
        normal.set(1, 0, 0);
      });
      trace.dot.position.copy(this.place(trace, motion, time));
    }
  }

  place({ number, point, used }, motion, time) {
    const [coordinates, key] = [motion.names.map(() => 0), motion.keyBefore(time)];
    for (const i of used) coordinates[i] = motion.value(i, time, key);
    return this.stage.end(motion.pose(this.stage.figure.bodies[number], number, coordinates, time), point, true).position;
  }
}
