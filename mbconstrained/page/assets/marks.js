// What a box on the page shows: perspective, names, frames of links, their collision geometry, centres of mass with ellipsoids of
// the same inertia.

const frameLength = 0.6; // in drawing units
const seenThrough = { depthTest: false, depthWrite: false, transparent: true };

// The axes of the frame of a body: x red, y green, z blue.
function frameMark(unit) {
  const axes = new THREE.AxesHelper(frameLength * unit);
  Object.assign(axes.material, seenThrough);
  axes.renderOrder = 2;
  return axes;
}

// A uniform ellipsoid with mass, centre and inertia of a body, and a dot at its centre.
function massMark(matrix, unit) {
  const look = Object.assign({ opacity: 0.4 }, seenThrough);
  const ellipsoid = new THREE.Mesh(new THREE.SphereGeometry(1, 32, 20), material("#e69f00", look));
  ellipsoid.applyMatrix4(new THREE.Matrix4().fromArray(matrix));
  const dot = new THREE.Mesh(new THREE.SphereGeometry(0.05 * unit, 16, 12), material("#d55e00", seenThrough));
  dot.position.copy(ellipsoid.position);
  [ellipsoid.renderOrder, dot.renderOrder] = [1, 2];
  return group(ellipsoid, dot);
}

// The collision shapes of a body, which the body is seen through.
function collisionMark(shapes, solids) {
  const whole = group(...shapes.map((shape) => solids.object(Object.assign({}, shape, { opacity: 0.35 }))));
  whole.traverse((part) => (part.castShadow = false));
  return whole;
}

const markMakers = {
  frames: ({ frame }, stage) => frame && frameMark(stage.figure.unit),
  collision: ({ collision }, stage) => collision.length > 0 && collisionMark(collision, stage.solids),
  masses: ({ ellipsoid }, stage) => ellipsoid && massMark(ellipsoid, stage.figure.unit),
};

// Shows or hides what a box on the page stands for; all but names are made when they are first shown.
function showMarks(stage, kind, shown) {
  stage.shows[kind] = shown;
  if (kind === "perspective") return stage.usePerspective(shown);
  if (kind === "names") stage.pane.querySelector(".labels").classList.toggle("off", !shown);
  else if (shown && !stage.marks[kind]) stage.marks[kind] = makeMarks(stage, kind);
  for (const mark of stage.marks[kind] || []) mark.visible = shown;
  stage.draw();
}

function makeMarks(stage, kind) {
  return stage.figure.bodies.flatMap((body, i) => {
    const mark = markMakers[kind](body, stage);
    if (!mark) return [];
    stage.bodies[i].add(mark);
    return [mark];
  });
}

function listenToMarks(stage) {
  for (const box of document.querySelectorAll("input[data-shows]")) {
    box.addEventListener("change", () => showMarks(stage, box.dataset.shows, box.checked));
    if (box.checked !== stage.shows[box.dataset.shows]) showMarks(stage, box.dataset.shows, box.checked); // kept by a reload
  }
}
