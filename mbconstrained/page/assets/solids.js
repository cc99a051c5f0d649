// Bodies of solids: boxes, cylinders, spheres and meshes with placements, and the base plate of a robot.

const solidGeometry = {
  box([width, depth, height]) {
    return new THREE.BoxGeometry(width, depth, height);
  },

  cylinder([radius, length]) {
    return new THREE.CylinderGeometry(radius, radius, length, 64).rotateX(Math.PI / 2); // the axis of three.js is y
  },

  sphere([radius]) {
    return new THREE.SphereGeometry(radius, 40, 24);
  },
};

// The solids of one figure; a mesh or an image is unpacked once and shared.
class Solids {
  // What is given last is called when an image has come.
  constructor(meshes, images, changed) {
    Object.assign(this, { meshes: meshes, images: images, changed: changed });
    this.unpacked = new Map();
    this.textures = new Map();
  }

  // A solid with its edges, so that links of one colour are distinct.
  object({ kind, size, matrix, color, opacity, mesh }) {
    const geometry = mesh === null ? solidGeometry[kind](size) : this.mesh(mesh);
    const clear = opacity < 1 ? { transparent: true, opacity: opacity, depthWrite: false } : {};
    const side = mesh === null ? THREE.FrontSide : THREE.DoubleSide; // meshes may be inside out, or open
    const image = mesh === null ? undefined : this.meshes[mesh].image;
    const look = image === undefined ? { color: color } : { color: "#ffffff", map: this.texture(image) };
    const whole = group(solid(geometry, color, Object.assign({ side: side, shininess: 35 }, look, clear)));
    if (kind !== "sphere") whole.add(this.outline(geometry, image === undefined ? color : ink));
    whole.applyMatrix4(new THREE.Matrix4().fromArray(matrix));
    return whole;
  }

  outline(geometry, color) {
    if (!geometry.userData.edges) geometry.userData.edges = new THREE.EdgesGeometry(geometry, sharpAngle);
    const tone = new THREE.Color(color).lerp(new THREE.Color(ink), 0.55);
    const line = new THREE.LineBasicMaterial({ color: tone, transparent: true, opacity: 0.7 });
    return new THREE.LineSegments(geometry.userData.edges, line);
  }

  mesh(number) {
    if (!this.unpacked.has(number)) {
      const { vertices, faces, bytes, places } = this.meshes[number];
      const geometry = meshGeometry(unpacked(vertices), unpack(faces, bytes === 2 ? Uint16Array : Uint32Array));
      if (places) {
        const down = Float32Array.from(unpacked(places), (value, i) => (i % 2 ? 1 - value : value)); // the first row of an image is on top
        geometry.setAttribute("uv", new THREE.BufferAttribute(down, 2));
      }
      this.unpacked.set(number, geometry);
    }
    return this.unpacked.get(number);
  }

  // The surface is white until the browser has decoded the image.
  texture(number) {
    if (!this.textures.has(number)) {
      const texture = new THREE.Texture();
      Object.assign(texture, { wrapS: THREE.RepeatWrapping, wrapT: THREE.RepeatWrapping, flipY: false });
      this.textures.set(number, texture);
      createImageBitmap(new Blob([unpack(this.images[number], Uint8Array)], { type: "image/jpeg" })).then((image) => {
        Object.assign(texture, { image: image, needsUpdate: true });
        this.changed();
      });
    }
    return this.textures.get(number);
  }
}

const sharpAngle = 35; // degrees between two faces with a visible edge

// Faces with normals that are smooth except at sharp edges: at each corner the mean, weighted by area, of the normals of
// the adjacent faces without a sharp edge to its own.
function meshGeometry(vertices, faces) {
  const count = faces.length / 3;
  const places = new Float32Array(9 * count);
  faces.forEach((vertex, corner) => places.set(vertices.subarray(3 * vertex, 3 * vertex + 3), 3 * corner));
  const normals = faceNormals(places, count);
  const around = new Map();
  faces.forEach((vertex, corner) => {
    if (!around.has(vertex)) around.set(vertex, []);
    around.get(vertex).push(Math.floor(corner / 3));
  });
  const smooth = new Float32Array(9 * count);
  faces.forEach((vertex, corner) => smooth.set(cornerNormal(normals, Math.floor(corner / 3), around.get(vertex)), 3 * corner));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(smooth, 3));
  return geometry;
}

// Per face its normal, as long as twice its area.
function faceNormals(places, count) {
  const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  return Array.from({ length: count }, (_, face) => {
    [a, b, c].forEach((corner, k) => corner.fromArray(places, 9 * face + 3 * k));
    return b.sub(a).cross(c.sub(a)).clone();
  });
}

function cornerNormal(normals, face, neighbours) {
  const own = normals[face];
  const sum = new THREE.Vector3();
  const limit = Math.cos((sharpAngle * Math.PI) / 180);
  for (const other of neighbours) {
    if (own.dot(normals[other]) >= limit * own.length() * normals[other].length()) sum.add(normals[other]);
  }
  return sum.normalize().toArray();
}

// A plate with hatching on its upper side, which is where the ground begins.
shapes.base = ([width, depth, height], color) => {
  const slab = solid(new THREE.BoxGeometry(width, depth, height), color);
  const strokes = hatching(width, depth, 0, Math.min(width, depth) / 8);
  strokes.rotateX(-Math.PI / 2).position.z = 0.505 * height;
  return group(slab, strokes, edges(slab.geometry));
};
