// Orbits: the paths of points of rotors, over the last revolution, or over a whole cycle; seen through the bodies.
const orbitColor = "#e8590c";

class Orbits {
  constructor(stage, { points, window }) {
    Object.assign(this, { stage: stage, window: window });
    this.traces = points.map(([number, point], k) => {
      const { moves, turns } = stage.figure.bodies[number];
      const wire = new Wire(128, 0.026, orbitColor, 6);
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
