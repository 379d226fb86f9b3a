// Data of the page: poses and values of the kept samples of its runs.
const figure = document.getElementById("robot");
if (!figure) return;
const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;

// Vectors are arrays of three numbers.
const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times3 = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = a => Math.hypot(a[0], a[1], a[2]);
const unit = a => { const n = norm(a); return n > 0 ? times3(a, 1 / n) : [0, 0, 1]; };
const perpendicular = a => unit(cross(a, Math.abs(a[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0]));

// A run; positions begin at the origin of the first one.
const open = (film, origin) => {
  const times = new Float64Array(bytes(film.times));
  const poses = new Float32Array(bytes(film.poses));
  const values = new Float64Array(bytes(film.values));
  const scene = film.scene, shift = minus(film.origin, origin);
  const frames = times.length, bodyCount = scene.bodies.length, width = film.columns.length;
  const columnOf = new Map(film.columns.map((name, k) => [name.replace(/ \[.*$/, ""), k]));
  const unitOf = new Map(film.columns.map(name => [name.replace(/ \[.*$/, ""), (/ \[(.*)\]$/.exec(name) || ["", ""])[1]]));
  // Value of a column at a sample; undefined for a column that the run does not have.
  const valueIn = (column, frame) => values[frame * width + column];
  const valueAt = (name, frame) => columnOf.has(name) ? valueIn(columnOf.get(name), frame) : undefined;
  const vectorAt = (object, letter, frame) => ["x", "y", "z"].map(axis => valueAt(`${object}.${letter}${axis}`, frame) || 0);
  // Direction of a body in world axes, and point of a body in the world.
  const turned = (frame, body, v) => {
    const at = (frame * bodyCount + body) * 7 + 3;
    const w = poses[at], q = [poses[at + 1], poses[at + 2], poses[at + 3]];
    const t = times3(cross(q, v), 2);
    return plus(plus(v, times3(t, w)), cross(q, t));
  };
  const placed = (frame, body, point) => {
    const at = (frame * bodyCount + body) * 7;
    return plus([poses[at] + shift[0], poses[at + 1] + shift[1], poses[at + 2] + shift[2]], turned(frame, body, point));
  };
  // Position and quaternion (w, x, y, z) of a body.
  const poseAt = (frame, body) => {
    const at = (frame * bodyCount + body) * 7;
    return { position: plus(poses.slice(at, at + 3), shift), quaternion: poses.slice(at + 3, at + 7) };
  };
  // Position of the symbol of a joint.
  const jointAt = (frame, joint) => {
    const from = placed(frame, joint.from, joint.at[0]), to = placed(frame, joint.to, joint.at[1]);
    return plus(from, times3(minus(to, from), joint.weight));
  };
  // Ends of a spring.
  const endsOf = (frame, spring) => spring.bodies.map((body, k) => placed(frame, body, spring.at[k]));
  // Bodies on which loads act, the force of such a load, and the start of its arrow.
  const loadOn = k => `load on ${scene.bodies[k].name}`;
  const loaded = scene.bodies.map((_, k) => k).filter(k => k && columnOf.has(`${loadOn(k)}.fx`));
  const loadAt = (frame, k) => vectorAt(loadOn(k), "f", frame);
  const loadFrom = (frame, k) => placed(frame, k, vectorAt(loadOn(k), "", frame));
  // The last kept sample that is not later than a time.
  const frameOf = time => {
    let low = 0, high = frames - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= time) low = middle; else high = middle - 1;
    }
    return low;
  };
  // The nearest kept sample.
  const nearestFrame = time => {
    const k = frameOf(time);
    return k + 1 < frames && times[k + 1] - time < time - times[k] ? k + 1 : k;
  };
  // Every so many samples, for sizes that need not be exact.
  const some = Array.from({ length: Math.min(frames, 160) }, (_, k) => Math.round(k * (frames - 1) / Math.max(1, Math.min(frames, 160) - 1)));
  return { film, label: film.label, scene, times, frames, columnOf, unitOf, valueIn, valueAt, vectorAt, turned, placed, poseAt, jointAt, endsOf, loaded, loadAt, loadFrom, frameOf, nearestFrame, some };
};

// The run of the controls, and those that can be laid over it.
const film = JSON.parse(figure.querySelector("script.film").textContent);
const run = open(film, film.origin), others = film.others.map(own => open(own, film.origin));
const { scene, times, frames, unitOf, valueAt, turned, placed, jointAt, frameOf, nearestFrame, some } = run;
if (!frames) return;

// Four significant digits, with the minus sign of tables.
const shown = x => {
  if (x === undefined || Number.isNaN(x)) return "none";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  if (x === 0) return "0";
  const size = Math.abs(x);
  const text = size >= 1e6 || size < 1e-4 ? x.toExponential(3) : String(Number(x.toPrecision(4)));
  return text.replace("-", "−");
};
const make = (name, attributes = {}, text = "") => {
  const element = document.createElement(name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (text) element.textContent = text;
  return element;
};
