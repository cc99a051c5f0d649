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
    const parts = new Parts(figure.meshes);
    const objects = figure.bodies.map((body) => bodyObject(body, parts, figure.unit));
    this.boxes = objects.map((object, i) => (figure.bodies[i].shape === "parts" ? boxAround(object) : null));
    this.bodies = objects.map((object, i) => this.place(["bodies", `body ${i}`], object));
    this.viewer.scene_tree.find(["mbconstrained", "bodies"]).object.scale.setScalar(1 / figure.unit);
    this.links = figure.links.map((link, i) => this.hang(link, i));
    this.labels = figure.bodies.map((body) => this.label(body));
    const named = figure.bodies.filter((body) => body.shape === "parts" && body.label);
    pane.querySelector(".labels").classList.toggle("many", named.length > 8);
    this.light();
    this.camera = this.aim();
    this.hidden = null; // found when it is first needed, and again when the view has been turned
    this.viewer.controls.addEventListener("end", () => this.lookAgain());
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
    this.lookAgain();
  }

  lookAgain() {
    this.hidden = null;
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

  // Moves everything to where it is at a time.
  show(motion, time) {
    const coordinates = motion.at(time);
    const poses = this.figure.bodies.map((body, i) => motion.pose(body, i, coordinates, time));
    poses.forEach(({ position, quaternion }, i) => {
      this.bodies[i].position.set(...position);
      this.bodies[i].quaternion.set(...quaternion);
    });
    for (const link of this.links) {
      const over = link.over === null ? null : this.end(poses[link.over], [0, 0, 0], false);
      const [from, to] = [poses[link.start], poses[link.end]];
      link.drawn.update(this.end(from, link.start_point, link.start_turns), this.end(to, link.end_point, link.end_turns), over);
    }
    this.draw();
  }

  // A link's end in drawing units, turned with the body where it is fixed in its frame.
  end({ position, quaternion, angle }, point, turns) {
    const place = new THREE.Vector3(...point);
    if (turns) place.applyQuaternion(new THREE.Quaternion(...quaternion));
    return { position: place.add(new THREE.Vector3(...position)).divideScalar(this.figure.unit), angle: angle };
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
    if (this.boxes[i]) return this.upon(i);
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

  // On the middle of the largest part of a body, or just above it where that is flat.
  upon(i) {
    const [width, height] = this.size;
    const seen = this.boxes[i].map((corner) => this.bodies[i].localToWorld(corner.clone()).project(this.camera));
    const [xs, ys] = [seen.map(({ x }) => ((x + 1) / 2) * width), seen.map(({ y }) => ((1 - y) / 2) * height)];
    const middle = (numbers) => (Math.min(...numbers) + Math.max(...numbers)) / 2;
    return [middle(xs), Math.max(Math.min(...ys), middle(ys) - 12)];
  }

  // Which bodies made of parts stand behind others: their names would be read as those of what hides them.
  behind() {
    const solids = this.bodies.map((body) => opaque(body));
    const own = (i, { object }) => solids[i].includes(object);
    const caster = new THREE.Raycaster();
    const covered = (i, point) => {
      const seen = point.clone().project(this.camera);
      caster.setFromCamera(new THREE.Vector2(seen.x, seen.y), this.camera);
      const [first] = caster.intersectObjects(solids.flat(), false);
      return Boolean(first) && !own(i, first) && first.distance < caster.ray.origin.distanceTo(point);
    };
    const hidden = (i) => pointsAlong(this.boxes[i]).every((point) => covered(i, this.bodies[i].localToWorld(point)));
    return this.figure.bodies.map(({ label }, i) => Boolean(this.boxes[i] && label) && hidden(i));
  }

  // Puts the names a little above their bodies; a name that would cover another one, or belongs to what is not seen, is left out.
  write() {
    this.hidden = this.hidden || this.behind();
    const taken = [];
    for (const i of this.order()) {
      const [label, [x, top]] = [this.labels[i], this.top(i)];
      const y = top - 4;
      label.style.transform = `translate(-50%, -100%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      const box = { left: x - label.offsetWidth / 2, right: x + label.offsetWidth / 2, top: y - label.offsetHeight, bottom: y };
      const free = taken.every((b) => box.right < b.left || box.left > b.right || box.bottom < b.top || box.top > b.bottom);
      const shown = free && !this.hidden[i];
      label.style.visibility = shown ? "visible" : "hidden";
      if (shown && label.textContent) taken.push(box);
    }
  }

  // In which order names take their room: of bodies made of parts the nearest first, the others as they come.
  order() {
    const eye = this.camera.getWorldDirection(new THREE.Vector3());
    const away = this.bodies.map((body, i) => (this.boxes[i] ? body.getWorldPosition(new THREE.Vector3()).dot(eye) : -Infinity));
    return this.bodies.map((_, i) => i).sort((a, b) => (away[a] === away[b] ? a - b : away[a] - away[b]));
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

function bodyObject(body, parts, unit) {
  if (body.shape === "parts") return group(...body.parts.map((part) => parts.object(part)));
  const whole = shapes[body.shape](body.size, body.color, body.teeth);
  for (const [x, y, z] of body.posts) {
    const post = bar(0.04 * unit, ink);
    post.quaternion.setFromUnitVectors(along(), new THREE.Vector3(x, y, z).normalize());
    post.scale.x = Math.hypot(x, y, z);
    whole.add(post);
  }
  return whole;
}

// The meshes of an object through which nothing is seen.
function opaque(object) {
  const found = [];
  object.traverse((part) => part.isMesh && !part.material.transparent && found.push(part));
  return found;
}

// The middle of a box given by its corners, and two points on either side of it where the box is longest.
function pointsAlong(corners) {
  const [low, high] = [corners[0], corners[7]];
  const size = high.clone().sub(low);
  const axis = ["x", "y", "z"].reduce((best, name) => (size[name] > size[best] ? name : best));
  return [-1, 0, 1].map((side) => {
    const point = low.clone().add(high).multiplyScalar(0.5);
    point[axis] += (side * size[axis]) / 3;
    return point;
  });
}

// The corners of a box around the largest part of an object, in its own frame.
function boxAround(object) {
  const boxes = object.children.map((part) => new THREE.Box3().setFromObject(part));
  const point = new THREE.Box3(new THREE.Vector3(), new THREE.Vector3());
  const reach = ({ min, max }) => min.distanceTo(max);
  const { min, max } = boxes.reduce((best, box) => (reach(box) > reach(best) ? box : best), point);
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new THREE.Vector3(x, y, z))));
}
