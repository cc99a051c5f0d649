// How far from its target the eye is with perspective, relative to the diagonal of the figure.
const nearness = 1.5;

// The stage: the meshcat viewer with the bodies and links of the figure in its scene tree, a camera that shows the
// whole motion, and names over the picture.
class Stage {
  constructor(pane, figure) {
    this.pane = pane;
    this.figure = figure;
    this.shows = { names: true, perspective: false, frames: false, collision: false, masses: false };
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
    this.solids = new Solids(figure.meshes, figure.images, () => this.viewer.set_dirty());
    const objects = figure.bodies.map((body) => bodyObject(body, this.solids, figure.unit));
    const boxes = objects.map((object, i) => (figure.bodies[i].shape === "solids" ? boxAround(object) : null));
    this.bodies = objects.map((object, i) => this.place(["bodies", `body ${i}`], object));
    this.turn = new THREE.Quaternion(...figure.turn);
    for (const all of ["bodies", "links", "overlay"]) this.node(all).quaternion.copy(this.turn);
    this.node("bodies").scale.setScalar(1 / figure.unit);
    this.links = figure.links.map((link, i) => this.addLink(link, i));
    this.names = new Names(this, boxes);
    this.overlay = figure.overlay ? new Overlay(this, figure.overlay) : null; // its script is included only where needed
    this.orbits = figure.rotors ? new Orbits(this, figure.rotors) : null;
    this.addLight();
    this.addCamera();
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
    for (const link of this.links) if (link.states) showEngagement(link, link.level, true);
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

  // A camera without perspective, and one with it for those who ask for it.
  addCamera() {
    const { low, high } = this.figure.bounds;
    this.reach = Math.hypot(...high.map((value, axis) => value - low[axis]));
    this.cameras = [new THREE.OrthographicCamera(), new THREE.PerspectiveCamera()];
    this.viewer.set_object(["Cameras", "default", "rotated"], this.cameras[0]);
    this.cameras[0].parent.add(this.cameras[1]);
    this.useCamera(this.cameras[0]);
    this.resetView();
  }

  useCamera(camera) {
    this.camera = camera;
    this.viewer.controls.dispose(); // those of the camera before
    this.viewer.set_camera(camera);
    this.viewer.controls.enableKeys = false;
    this.viewer.controls.addEventListener("end", () => this.updateNames());
    this.viewer.controls.addEventListener("change", () => this.setClipping());
  }

  // What is seen at the target of the view keeps its place and its size.
  usePerspective(shown) {
    const { camera, viewer } = this;
    const target = viewer.controls.target.clone();
    const gap = camera.position.clone().sub(target);
    const zoom = camera.isPerspectiveCamera ? nearness * this.reach / gap.length() : camera.zoom;
    this.useCamera(this.cameras[Number(shown)]);
    this.look(target, gap.normalize(), zoom);
    this.fit();
    this.updateNames();
  }

  // Looks at a target in a direction; with perspective the distance is what the zoom is without.
  look(target, towards, zoom) {
    const { camera, viewer } = this;
    const distance = camera.isPerspectiveCamera ? nearness / zoom : 4;
    if (!camera.isPerspectiveCamera) camera.zoom = zoom;
    camera.position.copy(target).addScaledVector(towards, distance * this.reach);
    viewer.controls.target.copy(target);
    viewer.controls.minDistance = this.reach / 20;
    viewer.controls.update();
    this.setClipping();
  }

  setClipping() {
    const distance = this.camera.position.distanceTo(this.viewer.controls.target);
    Object.assign(this.camera, { near: distance / 100, far: distance + 8 * this.reach });
  }

  // The view of the figure, turned and raised a little. The axes of the viewer's camera have y up.
  resetView() {
    const { bounds, view } = this.figure;
    const { yaw, pitch } = view;
    const middle = bounds.low.map((value, axis) => (value + bounds.high[axis]) / 2);
    const eye = [Math.sin(yaw) * Math.cos(pitch), -Math.cos(yaw) * Math.cos(pitch), Math.sin(pitch)];
    const upright = ([x, y, z]) => new THREE.Vector3(x, z, -y);
    this.look(upright(middle), upright(eye), view.zoom || 1);
  }

  reset() {
    this.resetView();
    this.fit();
    this.updateNames();
  }

  // Where a point of the scene is in the picture, in pixels; far outside for one behind the eye.
  pixels(point) {
    const { x, y, z } = point.clone().project(this.camera);
    const [width, height] = this.size;
    return z > 1 ? [-1e6, -1e6] : [((x + 1) / 2) * width, ((1 - y) / 2) * height];
  }

  // How long a distance across the view is in the picture, in pixels.
  pixelsOf(distance) {
    const middle = this.viewer.controls.target;
    const aside = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0).multiplyScalar(distance).add(middle);
    return this.pixels(aside)[0] - this.pixels(middle)[0];
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
    const header = this.pane.querySelector(".magnification").offsetHeight; // the text over the picture has space of its own
    this.pane.style.height = `${wanted + header}px`;
    const height = this.pane.clientHeight - header; // a style sheet may set another
    const half = Math.max(across * margin, ((up + Math.max(0.3, (70 * up) / height)) * width) / height);
    this.size = [width, height + header];
    this.setWindow(half, (half * this.size[1]) / width, header / 2);
    this.viewer.renderer.setSize(...this.size);
    this.viewer.set_dirty();
  }

  // What is seen at the target of the view: half its width and half its height; the middle is so many pixels lower in the picture.
  setWindow(across, up, lower) {
    const opening = (360 / Math.PI) * Math.atan(up / (nearness * this.reach));
    if (this.camera.isPerspectiveCamera) Object.assign(this.camera, { fov: opening, aspect: across / up });
    else Object.assign(this.camera, { left: -across, right: across, top: up, bottom: -up });
    this.camera.setViewOffset(...this.size, 0, -lower, ...this.size); // which updates the projection, too
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
      if (link.states) showEngagement(link, engagementAt(link.states, time)); // their script is included only where needed
      const stations = link.stations && link.stations.map((station) => this.station(poses, station));
      link.drawn.update(from, to, over, stations);
      link.ends = [from.position, to.position];
    }
    if (this.orbits) this.orbits.show(motion, time);
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

  // A station of a shaft with its direction there, or null where its body does not tilt.
  station(poses, [body, point, tilts]) {
    const slope = tilts ? along().applyQuaternion(new THREE.Quaternion(...poses[body].quaternion)) : null;
    return Object.assign(this.end(poses[body], point, true), { slope: slope });
  }

  draw() {
    this.viewer.render();
    const occupied = [...this.names.caption()];
    if (this.overlay) this.overlay.placeLabels(occupied);
    this.names.place(occupied);
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
