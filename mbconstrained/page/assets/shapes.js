// Bodies: one function per shape, each from the size (along x, y, z) and the colour to an object around its origin.
// Model axes: x to the right, y away from the viewer, z up.
const THREE = window.MeshCat ? window.MeshCat.THREE : null;

const ink = "#3d4852";
const steel = "#8795a1";

// With many bodies each is small: fewer faces suffice, without shadows.
const detail = { coarse: false };

function material(color, options) {
  return new THREE.MeshPhongMaterial(Object.assign({ color: color, shininess: 20, specular: "#222222" }, options));
}

function solid(geometry, color, options) {
  const mesh = new THREE.Mesh(geometry, material(color, options));
  mesh.castShadow = !detail.coarse;
  mesh.receiveShadow = !detail.coarse;
  return mesh;
}

function at(object, x, y, z) {
  object.position.set(x, y, z);
  return object;
}

function group(...objects) {
  const whole = new THREE.Group();
  if (objects.length) whole.add(...objects);
  return whole;
}

// A prism with the outline in the x-z plane, rounded by the bevel, from y = -depth / 2 to depth / 2.
function prism(outline, depth, bevel, color, roundness = 10) {
  const geometry = new THREE.ExtrudeGeometry(outline, {
    depth: Math.max(depth - 2 * bevel, depth / 100),
    bevelSize: bevel,
    bevelThickness: bevel,
    bevelOffset: -bevel,
    bevelSegments: detail.coarse ? 1 : 3,
    curveSegments: detail.coarse ? Math.ceil(roundness / 4) : roundness,
  });
  geometry.center();
  geometry.rotateX(Math.PI / 2);
  return solid(geometry, color);
}

function rectangle(width, height, radius) {
  const [x, z] = [width / 2, height / 2];
  const outline = new THREE.Shape();
  outline.absarc(x - radius, z - radius, radius, 0, Math.PI / 2);
  outline.absarc(-x + radius, z - radius, radius, Math.PI / 2, Math.PI);
  outline.absarc(-x + radius, -z + radius, radius, Math.PI, (3 * Math.PI) / 2);
  outline.absarc(x - radius, -z + radius, radius, (3 * Math.PI) / 2, 2 * Math.PI);
  return outline;
}

function circle(radius) {
  return new THREE.Shape().absarc(0, 0, radius, 0, 2 * Math.PI);
}

// A toothed outline: flanks lean by a quarter of the pitch, so that two wheels mesh without touching.
function toothed(radius, teeth, depth) {
  const pitch = (2 * Math.PI) / teeth;
  const points = [];
  for (let tooth = 0; tooth < teeth; tooth++) {
    for (const [share, reach] of [[-0.29, -1], [-0.14, 1], [0.14, 1], [0.29, -1]]) {
      const angle = (tooth + share) * pitch;
      const distance = radius + (reach * depth) / 2;
      points.push(new THREE.Vector2(distance * Math.cos(angle), distance * Math.sin(angle)));
    }
  }
  return new THREE.Shape(points);
}

// A hub, a spoke and a dot on the front of a wheel, which show its rotation.
function face(radius, thickness) {
  const front = -thickness / 2 - 0.012;
  const wheel = (r, y, color) => at(solid(new THREE.CylinderGeometry(r, r, 0.04, 40), color), 0, y, 0);
  const spoke = at(solid(new THREE.BoxGeometry(radius * 0.72, 0.03, radius * 0.1), "#ffffff"), radius * 0.4, front, 0);
  const dot = at(wheel(radius * 0.1, 0, "#ffffff"), radius * 0.76, front, 0);
  return [spoke, dot, wheel(radius * 0.18, front - 0.015, ink)];
}

const shapes = {
  box([width, depth, height], color) {
    const bevel = 0.08 * Math.min(width, depth, height);
    return group(prism(rectangle(width, height, bevel), depth, bevel, color));
  },

  sphere([width, depth, height], color) {
    const ball = solid(new THREE.SphereGeometry(0.5, 32, 20), color);
    ball.scale.set(width, depth, height);
    return group(ball);
  },

  disc([width, depth], color) {
    return group(prism(circle(width / 2), depth, 0.12 * depth, color, 64), ...face(width / 2, depth));
  },

  gear([width, depth], color, teeth) {
    const tooth = (1.7 * width) / teeth;
    return group(prism(toothed(width / 2, teeth, tooth), depth, 0.03 * depth, color), ...face(0.9 * (width / 2), depth));
  },

  ring([width, depth], color, teeth) {
    const tooth = (1.7 * width) / teeth;
    const outline = circle(0.57 * width);
    outline.holes.push(toothed(width / 2, teeth, tooth));
    return group(prism(outline, depth, 0.03 * depth, color, 64));
  },

  // A bar with a stroke across it at the zero of the coordinate.
  rail([width, depth, height], color) {
    const stroke = solid(new THREE.BoxGeometry(0.04, 1.02 * depth, 6 * height), ink);
    return group(solid(new THREE.BoxGeometry(width, depth, height), color), stroke);
  },

  mark([width, depth, height], color) {
    return shapes.sphere([width, depth, height], color);
  },

  ground([width, depth, height], color) {
    const slab = solid(new THREE.BoxGeometry(width, depth, height), color);
    return group(slab, hatching(width, height, -depth / 2 - 0.004), edges(slab.geometry));
  },
};

// Diagonal strokes on the front of the ground, clipped at its border.
function hatching(width, height, y, pitch = 0.14) {
  const points = [];
  for (let offset = -(width + height) / 2 + pitch / 2; offset < (width + height) / 2; offset += pitch) {
    const low = Math.max(-width / 2, -height / 2 - offset); // the stroke is z = x + offset
    const high = Math.min(width / 2, height / 2 - offset);
    if (low < high) points.push(low, y, low + offset, high, y, high + offset);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: "#606f7b" }));
}

function edges(geometry) {
  return new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({ color: "#606f7b" }));
}
