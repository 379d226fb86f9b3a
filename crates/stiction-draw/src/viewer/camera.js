// The camera: parallel projection along an axis towards the viewer.
const camera = { right: [1, 0, 0], up: [0, 0, 1], toward: [0, -1, 0], centre: [0, 0, 0], scale: 100, zoom: 1, fitted: "best" };

const look = (toward, up) => {
  camera.toward = unit(toward);
  const level = minus(up, times3(camera.toward, dot(up, camera.toward)));
  camera.up = norm(level) > 1e-6 ? unit(level) : perpendicular(camera.toward);
  camera.right = cross(camera.up, camera.toward);
};

// Turns a vector about a unit axis.
const spun = (v, axis, angle) => {
  const c = Math.cos(angle), s = Math.sin(angle);
  return plus(plus(times3(v, c), times3(cross(axis, v), s)), times3(axis, dot(axis, v) * (1 - c)));
};

// Orbits: about the upward axis of the scene, and up to views from straight above or below.
const orbit = (across, along) => {
  const above = dot(camera.up, scene.up) < 0 ? -1 : 1;
  let toward = spun(camera.toward, scene.up, -across * above), up = spun(camera.up, scene.up, -across * above);
  const right = cross(up, toward), tilted = spun(up, right, -along);
  if (dot(tilted, scene.up) * above >= -1e-9) [toward, up] = [spun(toward, right, -along), tilted];
  look(toward, up);
  camera.fitted = "";
};

// Everything that has to fit: joints, lonely bodies, springs, starts of loads and paths at some samples.
const extent = [];
for (const own of [run, ...others]) for (const frame of own.some) {
  own.scene.joints.forEach(joint => extent.push(own.jointAt(frame, joint)));
  own.scene.bodies.forEach((body, k) => { if (k && body.joints.length < 2 && body.mass > 0) extent.push(own.placed(frame, k, body.com)); });
  own.scene.springs.forEach(spring => extent.push(...own.endsOf(frame, spring)));
  own.loaded.forEach(k => extent.push(own.loadFrom(frame, k)));
  own.scene.traced.forEach(point => extent.push(own.placed(frame, point.body, point.at)));
}
if (!extent.length) extent.push([0, 0, 0]);

const room = { width: 600, height: 400 };
const fit = () => {
  const box = [camera.right, camera.up, camera.toward].map(axis => {
    let low = Infinity, high = -Infinity;
    for (const point of extent) { const x = dot(point, axis); if (x < low) low = x; if (x > high) high = x; }
    return [low, high];
  });
  const middle = box.map(([low, high]) => 0.5 * (low + high));
  camera.centre = plus(plus(times3(camera.right, middle[0]), times3(camera.up, middle[1])), times3(camera.toward, middle[2]));
  const spans = box.map(([low, high]) => high - low), most = Math.max(...spans, 1e-9);
  const margin = Math.min(110, 0.24 * room.width);
  camera.scale = Math.min((room.width - margin) / Math.max(spans[0], 0.05 * most), (room.height - (film.actuators.some(own => own.turns) ? 150 : 120)) / Math.max(spans[1], 0.05 * most));
};
const perMetre = () => camera.scale * camera.zoom;
// A point of the world in the picture, px, y downwards.
const project = point => {
  const d = minus(point, camera.centre), s = perMetre();
  return [0.5 * room.width + dot(d, camera.right) * s, 0.5 * room.height - 10 - dot(d, camera.up) * s];
};
const depthOf = point => dot(minus(point, camera.centre), camera.toward) * perMetre();
// Direction of the world in the picture, with its part towards the viewer.
const flat = v => [dot(v, camera.right), -dot(v, camera.up), dot(v, camera.toward)];

// Size of the symbols, px: small where joints are close to each other.
const symbolSize = () => {
  const points = scene.joints.slice(0, 200).map(joint => project(jointAt(some[0], joint)));
  const gaps = points.map((p, k) => points.reduce((least, q, l) => {
    const gap = Math.hypot(p[0] - q[0], p[1] - q[1]);
    return k !== l && gap > 4 ? Math.min(least, gap) : least;
  }, Infinity)).sort((a, b) => a - b);
  const typical = gaps.length ? gaps[gaps.length >> 2] : Infinity;
  return Math.min(10, Math.max(5.5, 0.17 * typical)) * (room.width < 480 ? 0.85 : 1);
};
