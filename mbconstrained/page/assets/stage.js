// How far wheels reach beyond their size, for their teeth or rim.
const wheels = { disc: 1, gear: 1.05, ring: 1.14 };

// The stage: the meshcat viewer with the bodies and links of the figure in its scene tree, a camera that shows the
// whole motion, and names as text over the picture.
class Stage {
  constructor(pane, figure) {
    this.pane = pane;
    this.figure = figure;
    this.viewer = new window.MeshCat.Viewer(pane.querySelector(".view"), false);
    this.viewer.gui.domElement.remove();
    for (const command of figure.commands) this.viewer.handle_command(command);
    this.bodies = figure.bodies.map((body, i) => this.place(["bodies", `body ${i}`], bodyObject(body)));
    this.links = figure.links.map((link, i) => this.hang(link, i));
    this.labels = figure.bodies.map((body) => this.label(body));
    this.light();
    this.camera = this.aim();
    this.viewer.set_3d_pane_size = () => this.fit(); // the viewer's own fills the window
    this.fit();
    this.quietWheel();
  }

  // Puts an object into the scene tree; returns the node's object, which is the one to move.
  place(path, object) {
    const full = ["mbconstrained", ...path];
    this.viewer.set_object(full, object);
    return this.viewer.scene_tree.find(full).object;
  }

  hang(link, i) {
    const drawn = new kinds[link.kind](link);
    this.place(["links", `link ${i}`], drawn.object);
    return Object.assign({ drawn: drawn }, link);
  }

  label(body) {
    const label = document.createElement("span");
    label.className = "label";
    label.textContent = body.label;
    this.pane.querySelector(".labels").append(label);
    return label;
  }

  light() {
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

  // A camera without perspective, turned and raised a little. The viewer's camera lives in axes with y up.
  aim() {
    const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 1000);
    this.viewer.controls.dispose(); // those of the camera that the viewer began with
    this.viewer.set_camera(camera);
    this.viewer.set_object(["Cameras", "default", "rotated"], camera);
    this.viewer.controls.enableKeys = false;
    this.look(camera);
    return camera;
  }

  look(camera) {
    const { low, high } = this.figure.bounds;
    const { yaw, pitch } = this.figure.view;
    const middle = low.map((value, axis) => (value + high[axis]) / 2);
    const away = 4 * Math.hypot(...high.map((value, axis) => value - low[axis]));
    const eye = [Math.sin(yaw) * Math.cos(pitch), -Math.cos(yaw) * Math.cos(pitch), Math.sin(pitch)];
    const upright = ([x, y, z]) => new THREE.Vector3(x, z, -y);
    camera.far = 3 * away;
    camera.zoom = 1;
    camera.position.copy(upright(middle.map((value, axis) => value + away * eye[axis])));
    this.viewer.controls.target.copy(upright(middle));
    this.viewer.controls.update();
  }

  reset() {
    this.look(this.camera);
    this.fit();
    this.draw();
  }

  // Half width and half height of the figure as the camera sees it.
  extent() {
    const { low, high } = this.figure.bounds;
    const { yaw, pitch } = this.figure.view;
    const [x, y, z] = high.map((value, axis) => (value - low[axis]) / 2);
    const across = x * Math.cos(yaw) + y * Math.abs(Math.sin(yaw));
    const up = z * Math.cos(pitch) + (x * Math.abs(Math.sin(yaw)) + y * Math.cos(yaw)) * Math.sin(pitch);
    return [across, up];
  }

  fit() {
    const [across, up] = this.extent();
    const width = this.pane.clientWidth || 800;
    const margin = 1 + 70 / width;
    const height = Math.round(Math.min(520, Math.max(240, (width * (up + 0.25)) / across)));
    const half = Math.max(across * margin, ((up + 0.3) * width) / height);
    Object.assign(this.camera, { left: -half, right: half, top: (half * height) / width, bottom: (-half * height) / width });
    this.camera.updateProjectionMatrix();
    this.size = [width, height];
    this.pane.style.height = `${height}px`;
    this.viewer.renderer.setSize(width, height);
    this.viewer.set_dirty();
  }

  // The wheel scrolls the page; with the control key it zooms the picture.
  quietWheel() {
    const stop = (event) => event.ctrlKey || event.stopPropagation();
    this.pane.addEventListener("wheel", stop, { capture: true });
  }

  // Moves everything to where the coordinates say.
  show(coordinates) {
    const poses = this.figure.bodies.map((body) => poseOf(body, coordinates));
    poses.forEach(({ position, turn }, i) => {
      const axis = new THREE.Vector3(...turn);
      const angle = axis.length();
      this.bodies[i].position.set(...position);
      this.bodies[i].quaternion.setFromAxisAngle(angle > 0 ? axis.divideScalar(angle) : along(), angle);
    });
    const end = (i, point) => ({
      position: new THREE.Vector3(...poses[i].position).add(new THREE.Vector3(...point)),
      angle: poses[i].turn[1],
    });
    for (const link of this.links) {
      const over = link.over === null ? null : end(link.over, [0, 0, 0]);
      link.drawn.update(end(link.start, link.start_point), end(link.end, link.end_point), over);
    }
    this.draw();
  }

  draw() {
    this.viewer.render();
    this.write();
  }

  drawIfNeeded() {
    if (this.viewer.needs_render) this.draw();
  }

  // Above the middle of a body, in pixels, as high as its highest edge is seen.
  top(i) {
    const { shape, size } = this.figure.bodies[i];
    const middle = this.bodies[i].getWorldPosition(new THREE.Vector3()); // in axes with y up
    const seen = (x, y, z) => middle.clone().add(new THREE.Vector3(x, y, z)).project(this.camera);
    const { x, y } = seen(0, 0, 0);
    const across = (size[0] / 2) * (seen(1, 0, 0).y - y);
    const up = (size[2] / 2) * (seen(0, 1, 0).y - y);
    const away = (size[1] / 2) * (seen(0, 0, 1).y - y);
    const face = wheels[shape] ? wheels[shape] * Math.hypot(across, up) : Math.abs(across) + Math.abs(up);
    const [width, height] = this.size;
    return [((x + 1) / 2) * width, ((1 - (y + face + Math.abs(away))) / 2) * height];
  }

  // Puts the names a little above their bodies; a name that would cover another one is left out.
  write() {
    const taken = [];
    this.labels.forEach((label, i) => {
      const [x, top] = this.top(i);
      const y = top - 4;
      label.style.transform = `translate(-50%, -100%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      const box = { left: x - label.offsetWidth / 2, right: x + label.offsetWidth / 2, top: y - label.offsetHeight, bottom: y };
      const free = taken.every((b) => box.right < b.left || box.left > b.right || box.bottom < b.top || box.top > b.bottom);
      label.style.visibility = free ? "visible" : "hidden";
      if (free && label.textContent) taken.push(box);
    });
  }

  // What the viewer's scene tree says about each body.
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

function bodyObject(body) {
  const whole = shapes[body.shape](body.size, body.color, body.teeth);
  for (const [x, y, z] of body.posts) {
    const post = bar(0.04, ink);
    post.quaternion.setFromUnitVectors(along(), new THREE.Vector3(x, y, z).normalize());
    post.scale.x = Math.hypot(x, y, z);
    whole.add(post);
  }
  return whole;
}
