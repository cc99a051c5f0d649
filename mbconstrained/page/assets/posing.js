// Sliders that pose a robot near its posture, in place of its motion: the coordinates are q = columns s, and each link moves by
// the product of the exponentials of the twists of its own coordinates.
const sliders = [...document.querySelectorAll("input[data-joint]")];

// Of a twist: the velocity at the origin, then the rate of rotation.
function exponential([x, y, z, ...rate], q) {
  const velocity = new THREE.Vector3(x, y, z);
  const axis = new THREE.Vector3(...rate);
  const square = axis.lengthSq();
  if (square === 0) return new THREE.Matrix4().setPosition(velocity.multiplyScalar(q));
  const turn = quaternionOf(rate.map((value) => value * q));
  const radius = axis.clone().cross(velocity).divideScalar(square); // of the axis from the origin
  const along = axis.multiplyScalar((axis.dot(velocity) / square) * q);
  const place = radius.clone().sub(radius.applyQuaternion(turn)).add(along);
  return new THREE.Matrix4().makeRotationFromQuaternion(turn).setPosition(place);
}

// The motion that is shown, with the links where the sliders put them.
function posedMotion() {
  const { columns, twists, bodies } = data.figure.posing;
  const values = sliders.map((slider) => Number(slider.value));
  const steps = columns.map((row, i) => exponential(twists[i], row.reduce((sum, entry, k) => sum + entry * values[k], 0)));
  const pose = (body, number, coordinates, time) => {
    if (!bodies[number]) return player.motion.pose(body, number, coordinates, time);
    const { moving, rest } = bodies[number];
    const matrix = moving.reduce((product, i) => product.multiply(steps[i]), new THREE.Matrix4());
    const position = new THREE.Vector3(...rest.slice(0, 3)).applyMatrix4(matrix);
    const turn = new THREE.Quaternion().setFromRotationMatrix(matrix).multiply(new THREE.Quaternion(...rest.slice(3)));
    return { position: position.toArray(), quaternion: turn.toArray(), turn: [0, 0, 0] };
  };
  return Object.assign(Object.create(player.motion), { pose: pose });
}

function showPosed(posed) {
  control("stage").classList.toggle("posed", posed); // which hides what is said of the motion
  if (player.stage) player.stage.node("overlay").visible = !posed;
  for (const slider of sliders) {
    slider.nextElementSibling.value = `${Number(Number(slider.value).toPrecision(3))} ${slider.dataset.unit}`;
  }
}

function poseBySliders() {
  player.playing = false;
  showPosed(true);
  player.stage.show(posedMotion(), player.time);
  publish();
}

function resetSliders() {
  for (const slider of sliders) slider.value = 0;
}

// Called where the motion is shown again.
function leavePosing() {
  if (!control("stage").classList.contains("posed")) return;
  resetSliders();
  showPosed(false);
}

function listenToSliders() {
  for (const slider of sliders) slider.addEventListener("input", poseBySliders);
  control("posture").addEventListener("click", () => {
    resetSliders();
    poseBySliders();
  });
}
