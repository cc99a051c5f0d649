// The stage: the meshcat viewer with the bodies and links of the figure in its scene tree, a camera that shows the
// whole motion, and names over the picture.
class Stage {
  constructor(pane, figure) {
    this.pane = pane;
    this.figure = figure;
    this.shows = { names: true, frames: false, masses: false };
    this.marks = {};
    this.viewer = new window.MeshCat.Viewer(pane.querySelector(".view"), false);
    this.viewer.gui.domElement.remove();
    detail.coarse = figure.bodies.length + figure.links.length > 100;
    Object.assign(this.viewer.renderer.shadowMap, { enabled: !detail.coarse, autoUpdate: false }); // only what moves changes shadows
    for (const name of ["Grid", "Axes", "Background", "Lights/PointLightNegativeX", "Lights/PointLightPositiveX", "Lights/FillLight"]) {
      this.viewer.handle_command({ type: "set_property", path: `/${name}`, property: "visible", value: false });
    }
    // a soft light from everywhere instead of spot lights
    this.viewer.handle_command({ type: "set_property", path: "/Lights/AmbientLight/\x3cobject>", property: "intensity", value: 0.68 });
    const solids = new Solids(figure.meshes);
    const objects = figure.bodies.map((body) => bodyObject(body, solids, figure.unit));
    const boxes = objects.map((object, i) => (figure.bodies[i].shape === "solids" ? boxAround(object) : null));
    this.bodies = objects.map((object, i) => this.place(["bodies", `body ${i}`], object));
    this.turn = new THREE.Quaternion(...figure.turn);
    for (const all of ["bodies", "links", "overlay"]) this.node(all).quaternion.copy(this.turn);
    this.node("bodies").scale.setScalar(1 / figure.unit);
    this.links = figure.links.map((link, i) => this.addLink(link, i));
    this.names = new Names(this, boxes);
    this.overlay = figure.overlay ? new Overlay(this, figure.overlay) : null; // its script is included only where needed
    this.addLight();
    this.camera = this.addCamera();
    this.viewer.controls.addEventListener("end", () => this.updateNames());
    this.viewer.set_3d_pane_size = () => this.fit(); // instead of the viewer's own, which fills the window
    this.fit();
    this.restrictWheel();
  }

  // Puts an object into the scene tree; returns the node's object, which is the one to move.
  place(path, object) {
    const full = ["mbconstrained", ...path];
    this.viewer.set_object(full, object);
    return this.viewer.scene_tree.find(full).object;
  }

  // The parent of all objects of a kind.
  node(kind) {
    return this.viewer.scene_tree.find(["mbconstrained", kind]).object;
  }

  // On a dark background dark greys are lightened a little, to remain visible.
  setTheme(dark) {
    const glow = new THREE.Color(dark ? "#2f3942" : "#000000");
    const hsl = {};
    this.viewer.scene.traverse(({ material }) => {
      if (!material || !material.emissive) return;
      const { s, l } = material.color.getHSL(hsl);
      if (s < 0.35 && l < 0.6) material.emissive.copy(glow);
    });
    this.viewer.set_dirty();
  }

  addLink(link, i) {
    const drawn = new kinds[link.kind](link);
    const frame = this.place(["links", `link ${i}`], link.turn ? group(drawn.object) : drawn.object);
    if (!link.turn) return Object.assign({ drawn: drawn }, link);
    frame.quaternion.set(...link.turn);
    return Object.assign({ drawn: drawn }, link, { back: frame.quaternion.clone().conjugate() });
  }

  addLight() {
    const { low, high } = this.figure.bounds;
    const middle = new THREE.Vector3(...low).add(new THREE.Vector3(...high)).multiplyScalar(0.5);
    const reach = new THREE.Vector3(...high).distanceTo(new THREE.Vector3(...low));
    const lamp = new THREE.DirectionalLight("#ffffff", 0.5);
    lamp.position.set(middle.x - 0.35 * reach, middle.y - 0.75 * reach, middle.z + 1.5 * reach);
    lamp.target.position.copy(middle);
    lamp.castShadow = true;
    lamp.shadow.mapSize.set(2048, 2048);
    lamp.shadow.radius = 3;
    lamp.shadow.bias = -0.001;
    Object.assign(lamp.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0, far: 4 * reach });
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(8 * reach, 8 * reach), new THREE.ShadowMaterial({ opacity: 0.1 }));
    floor.position.set(middle.x, middle.y, low[2] - 0.02);
    floor.receiveShadow = true;
    this.place(["lamp"], group(lamp, lamp.target));
    this.place(["floor"], floor);
  }

  // A camera without perspective, turned and raised a little. The axes of the viewer's camera have y up.
  addCamera() {
    const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 1000);
    this.viewer.controls.dispose(); // those of the camera of the viewer at first
    this.viewer.set_camera(camera);
    this.viewer.set_object(["Cameras", "default", "rotated"], camera);
    this.viewer.controls.enableKeys = false;
    this.setView(camera);
    return camera;
  }

  setView(camera) {
    const { low, high } = this.figure.bounds;
    const { yaw, pitch } = this.figure.view;
    const middle = low.map((value, axis) => (value + high[axis]) / 2);
    const distance = 4 * Math.hypot(...high.map((value, axis) => value - low[axis]));
    const eye = [Math.sin(yaw) * Math.cos(pitch), -Math.cos(yaw) * Math.cos(pitch), Math.sin(pitch)];
    const upright = ([x, y, z]) => new THREE.Vector3(x, z, -y);
    camera.far = 3 * distance;
    camera.zoom = this.figure.view.zoom || 1;
    camera.position.copy(upright(middle.map((value, axis) => value + distance * eye[axis])));
    this.viewer.controls.target.copy(upright(middle));
    this.viewer.controls.update();
  }

  reset() {
    this.setView(this.camera);
    this.fit();
    this.updateNames();
  }

  updateNames() {
    this.names.viewChanged();
    this.draw();
  }

  // Half width and half height of the figure in the view.
  extent() {
    const { low, high } = this.figure.bounds;
    const { yaw, pitch } = this.figure.view;
    const [x, y, z] = high.map((value, axis) => (value - low[axis]) / 2);
    const [cos, sin, rise, fall] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)].map(Math.abs);
    const across = x * cos + y * sin;
    const up = z * rise + (x * sin + y * cos) * fall;
    return [across, up];
  }

  fit() {
    const [across, up] = this.extent();
    const width = this.pane.clientWidth || 800;
    const margin = 1 + 70 / width;
    const wanted = Math.round(Math.min(520, Math.max(240, (width * (up + 0.25)) / across)));
    const lines = this.pane.querySelector(".magnification").offsetHeight;
    const header = lines > 30 ? lines : 0; // more than one line over the picture has space of its own
    this.pane.style.height = `${wanted + header}px`;
    const height = this.pane.clientHeight - header; // a style sheet may set another
    const half = Math.max(across * margin, ((up + Math.max(0.3, (70 * up) / height)) * width) / height);
    const [top, bottom] = [(half * (height + 2 * header)) / width, (-half * height) / width];
    Object.assign(this.camera, { left: -half, right: half, top: top, bottom: bottom });
    this.camera.updateProjectionMatrix();
    this.size = [width, height + header];
    this.viewer.renderer.setSize(...this.size);
    this.viewer.set_dirty();
  }

  // The wheel scrolls the page; with the control key it zooms the picture.
  restrictWheel() {
    const stop = (event) => event.ctrlKey || event.stopPropagation();
    this.pane.addEventListener("wheel", stop, { capture: true });
  }

  // Moves everything to its position at a time.
  show(motion, time) {
    const coordinates = motion.at(time);
    const poses = this.figure.bodies.map((body, i) => motion.pose(body, i, coordinates, time));
    poses.forEach(({ position, quaternion }, i) => {
      this.bodies[i].position.set(...position);
      this.bodies[i].quaternion.set(...quaternion);
    });
    for (const link of this.links) {
      const over = link.over === null ? null : this.end(poses[link.over], [0, 0, 0], false, link.back);
      const from = this.end(poses[link.start], link.start_point, link.start_turns, link.back);
      const to = this.end(poses[link.end], link.end_point, link.end_turns, link.back);
      link.drawn.update(from, to, over);
      link.ends = [from.position, to.position];
    }
    if (this.overlay) this.overlay.show(poses, coordinates, time, motion);
    this.viewer.renderer.shadowMap.needsUpdate = true;
    this.draw();
  }

  // The end of a link in drawing units and in the frame of the link; it turns with the body where it is fixed in its frame.
  end({ position, quaternion, turn }, point, turns, back) {
    const place = new THREE.Vector3(...point);
    if (turns) place.applyQuaternion(new THREE.Quaternion(...quaternion));
    place.add(new THREE.Vector3(...position)).divideScalar(this.figure.unit);
    const angle = back ? new THREE.Vector3(...turn).applyQuaternion(back).y : turn[1];
    return { position: back ? place.applyQuaternion(back) : place, angle: angle };
  }

  draw() {
    this.viewer.render();
    this.names.place(this.overlay ? this.overlay.placeLabels() : []);
  }

  drawIfNeeded() {
    if (this.viewer.needs_render) this.draw();
  }

  // The state of each body in the viewer's scene tree.
  nodes() {
    const nodes = Object.create(null);
    this.figure.bodies.forEach((body, i) => {
      const { position, quaternion, scale, visible } = this.bodies[i];
      nodes[body.name] = {
        position: position.toArray(),
        quaternion: quaternion.toArray(),
        scale: scale.toArray(),
        visible: visible,
      };
    });
    return nodes;
  }
}

function bodyObject(body, solids, unit) {
  if (body.shape === "solids") return group(...body.solids.map((solid) => solids.object(solid)));
  const whole = shapes[body.shape](body.size, body.color, body.teeth);
  for (const [x, y, z] of body.posts) {
    const post = bar(0.04 * unit, ink);
    post.quaternion.setFromUnitVectors(along(), new THREE.Vector3(x, y, z).normalize());
    post.scale.x = Math.hypot(x, y, z);
    whole.add(post);
  }
  return whole;
}
