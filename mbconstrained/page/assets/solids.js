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
// the adjacent faces without a sharp edge to its own. Its sharp edges are in its data.
function meshGeometry(vertices, faces) {
  const places = new Float32Array(3 * faces.length);
  faces.forEach((vertex, corner) => places.set(vertices.subarray(3 * vertex, 3 * vertex + 3), 3 * corner));
  const surface = new Surface(vertices.length / 3, faces, places);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(surface.cornerNormals(), 3));
  geometry.userData.edges = new THREE.BufferGeometry();
  geometry.userData.edges.setAttribute("position", new THREE.Float32BufferAttribute(surface.sharpEdges(), 3));
  return geometry;
}

// The faces around each vertex, and the normals of all faces.
class Surface {
  constructor(count, faces, places) {
    Object.assign(this, { faces: faces, places: places, cosine: Math.cos((sharpAngle * Math.PI) / 180) });
    this.starts = new Uint32Array(count + 1); // of the faces around a vertex in the list of all
    for (const vertex of faces) this.starts[vertex + 1]++;
    for (let i = 0; i < count; i++) this.starts[i + 1] += this.starts[i];
    const next = this.starts.slice();
    this.around = new Uint32Array(faces.length);
    faces.forEach((vertex, corner) => (this.around[next[vertex]++] = Math.floor(corner / 3)));
    this.findNormals();
  }

  // Per face its normal, as long as twice its area, and its length.
  findNormals() {
    const { places, faces } = this;
    this.normals = new Float64Array(faces.length);
    this.lengths = new Float64Array(faces.length / 3);
    const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    for (let face = 0; face < this.lengths.length; face++) {
      [a, b, c].forEach((corner, k) => corner.fromArray(places, 9 * face + 3 * k));
      this.lengths[face] = b.sub(a).cross(c.sub(a)).length();
      b.toArray(this.normals, 3 * face);
    }
  }

  isSharp(face, other) {
    const [n, i, j] = [this.normals, 3 * face, 3 * other];
    return n[i] * n[j] + n[i + 1] * n[j + 1] + n[i + 2] * n[j + 2] < this.cosine * this.lengths[face] * this.lengths[other];
  }

  cornerNormals() {
    const { faces, starts, around, normals } = this;
    const smooth = new Float32Array(this.places.length);
    const sum = new THREE.Vector3();
    for (let corner = 0; corner < faces.length; corner++) {
      sum.set(0, 0, 0);
      const face = Math.floor(corner / 3);
      for (let k = starts[faces[corner]]; k < starts[faces[corner] + 1]; k++) {
        const i = 3 * around[k];
        if (!this.isSharp(face, around[k])) sum.set(sum.x + normals[i], sum.y + normals[i + 1], sum.z + normals[i + 2]);
      }
      sum.normalize().toArray(smooth, 3 * corner);
    }
    return smooth;
  }

  // The ends of edges of one face alone, and of those at which two faces meet at a sharp angle; each once.
  sharpEdges() {
    const { faces, starts, around, places } = this;
    const ends = [];
    for (let corner = 0; corner < faces.length; corner++) {
      const face = Math.floor(corner / 3);
      const following = corner % 3 === 2 ? corner - 2 : corner + 1;
      let [shared, drawn] = [false, true];
      for (let k = starts[faces[corner]]; k < starts[faces[corner] + 1] && drawn; k++) {
        if (around[k] === face || !this.has(around[k], faces[following])) continue;
        shared = true;
        drawn = face < around[k] && this.isSharp(face, around[k]);
      }
      if (drawn || !shared) for (const end of [corner, following]) ends.push(...places.subarray(3 * end, 3 * end + 3));
    }
    return ends;
  }

  has(face, vertex) {
    return this.faces[3 * face] === vertex || this.faces[3 * face + 1] === vertex || this.faces[3 * face + 2] === vertex;
  }
}

// A plate with hatching on its upper side, which is where the ground begins.
shapes.base = ([width, depth, height], color) => {
  const slab = solid(new THREE.BoxGeometry(width, depth, height), color);
  const strokes = hatching(width, depth, 0, Math.min(width, depth) / 8);
  strokes.rotateX(-Math.PI / 2).position.z = 0.505 * height;
  return group(slab, strokes, edges(slab.geometry));
};
