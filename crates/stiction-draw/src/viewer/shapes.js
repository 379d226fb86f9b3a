// Symbols of joints as solids in the direction of view, and other shapes on the canvas.
const canvas = figure.querySelector("canvas");
let pen = canvas.getContext("2d");
let ink = {}, size = 8;
const refreshColours = () => {
  const style = getComputedStyle(document.documentElement);
  const names = ["paper", "ink", "soft", "edge", "tint", "link", "bad", "good", "open", "grid", "side", "drive", "driveside", "hub", "hubedge", "plate", "mark"];
  for (let k = 0; k < 7; k++) names.push(`leg${k}`);
  ink = Object.fromEntries(names.map(name => [name, style.getPropertyValue(`--${name}`).trim()]));
};

const trace = (points, closed) => {
  pen.beginPath();
  points.forEach((p, k) => k ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1]));
  if (closed) pen.closePath();
};
const stroke = (colour, width, dash = []) => {
  pen.strokeStyle = colour; pen.lineWidth = width; pen.setLineDash(dash); pen.stroke(); pen.setLineDash([]);
};
const fill = (colour, alpha = 1) => { pen.globalAlpha = alpha; pen.fillStyle = colour; pen.fill(); pen.globalAlpha = 1; };
const segment = (a, b, colour, width, dash) => { trace([a, b]); stroke(colour, width, dash); };
const disc = (at, radius, colour, edge) => {
  pen.beginPath(); pen.arc(at[0], at[1], radius, 0, 2 * Math.PI); fill(colour); if (edge) stroke(edge, 1.3);
};
const shift = (at, direction, length) => { const d = flat(direction); return [at[0] + d[0] * length, at[1] + d[1] * length]; };
const words = (text, at, colour, align = "center", font = "13px system-ui,Helvetica,Arial,sans-serif") => {
  pen.font = font; pen.textAlign = align; pen.textBaseline = "middle"; pen.lineJoin = "round";
  pen.strokeStyle = ink.paper; pen.lineWidth = 3.5; pen.strokeText(text, at[0], at[1]);
  pen.fillStyle = colour; pen.fillText(text, at[0], at[1]);
};

// Corners of the convex hull of points.
const hull = points => {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1])
    .filter((p, k, all) => !k || Math.hypot(p[0] - all[k - 1][0], p[1] - all[k - 1][1]) > 0.5);
  if (sorted.length < 3) return sorted;
  const half = list => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1) {
        const [o, a] = chain.slice(-2);
        if ((a[0] - o[0]) * (p[1] - o[1]) - (a[1] - o[1]) * (p[0] - o[0]) > 1) break;
        chain.pop();
      }
      chain.push(p);
    }
    chain.pop();
    return chain;
  };
  return [...half(sorted), ...half(sorted.reverse())];
};

const axisLine = (at, axis, reach) => {
  const a = shift(at, axis, -reach), b = shift(at, axis, reach);
  if (Math.hypot(a[0] - b[0], a[1] - b[1]) > 2.4 * size) segment(a, b, ink.mark, 1, [6, 3, 1.5, 3]);
};
const cylinder = (face, at, axis, length, r) => {
  if (flat(axis)[2] < 0) axis = times3(axis, -1);
  const [x, y, deep] = flat(axis), across = Math.hypot(x, y);
  if (across < 0.02) { disc(at, r, face.bright, ink.ink); disc(at, 0.28 * r, ink.ink); return; }
  const angle = Math.atan2(y, x), squeeze = Math.max(0.02, Math.min(1, deep));
  const far = shift(at, axis, -0.5 * length), near = shift(at, axis, 0.5 * length);
  // The far half of the rim, the sides, and the near rim; an ellipse's long axis is across the cylinder.
  pen.beginPath();
  pen.ellipse(near[0], near[1], r * squeeze, r, angle, -Math.PI / 2, Math.PI / 2);
  pen.ellipse(far[0], far[1], r * squeeze, r, angle, Math.PI / 2, 1.5 * Math.PI);
  pen.closePath(); fill(face.dim); stroke(ink.ink, 1.3);
  pen.beginPath(); pen.ellipse(near[0], near[1], r * squeeze, r, angle, 0, 2 * Math.PI);
  fill(face.bright); stroke(ink.ink, 1.3);
};
// A box given by its axes and half lengths: its visible faces, the most visible one last and brightest.
const box = (face, at, axes, half) => {
  const sides = [0, 1, 2].map(k => [Math.abs(flat(axes[k])[2]), k, Math.sign(flat(axes[k])[2])]).filter(s => s[0] > 0.02);
  sides.sort((a, b) => a[0] - b[0]);
  sides.forEach(([, k, sign], order) => {
    const i = (k + 1) % 3, j = (k + 2) % 3, centre = shift(at, axes[k], sign * half[k]);
    const corner = (a, b) => shift(shift(centre, axes[i], a * half[i]), axes[j], b * half[j]);
    trace([corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)], true);
    fill(order === sides.length - 1 ? face.bright : face.dim); stroke(ink.ink, 1.3);
  });
};
const symbol = (joint, frame, at, face) => {
  const r = size, axes = joint.axes.map(axis => turned(frame, joint.from, axis)), axis = axes[2];
  switch (joint.type) {
    case "R": axisLine(at, axis, 3.4 * r); cylinder(face, at, axis, 1.9 * r, r); break;
    case "P": {
      axisLine(at, axis, 4.6 * r);
      const level = cross(axis, camera.toward), side = norm(level) > 1e-6 ? unit(level) : perpendicular(axis);
      box(face, at, [axis, side, cross(axis, side)], [2.1 * r, 1.15 * r, 1.15 * r]); break;
    }
    case "C": axisLine(at, axis, 5 * r); segment(shift(at, axis, -3.4 * r), shift(at, axis, 3.4 * r), ink.ink, 3);
      cylinder(face, at, axis, 3.2 * r, 0.9 * r); break;
    case "H": {
      axisLine(at, axis, 5 * r); cylinder(face, at, axis, 3.6 * r, 0.9 * r);
      const [x, y] = flat(axis), across = Math.hypot(x, y);
      if (across > 0.02) for (let k = -2; k <= 2; k++) {
        const a = shift(at, axis, (k / 6 - 0.07) * 3.6 * r), b = shift(at, axis, (k / 6 + 0.07) * 3.6 * r);
        const n = [-y / across * 0.9 * r, x / across * 0.9 * r];
        segment([a[0] - n[0], a[1] - n[1]], [b[0] + n[0], b[1] + n[1]], ink.ink, 1.1);
      }
      break;
    }
    case "U": {
      const pins = [axis, turned(frame, joint.to, joint.second)];
      pins.forEach(pin => axisLine(at, pin, 3.3 * r));
      pins.sort((a, b) => Math.abs(flat(a)[2]) - Math.abs(flat(b)[2]));
      pins.forEach(pin => cylinder(face, at, pin, 3.3 * r, 0.55 * r)); break;
    }
    case "S": disc(at, 1.05 * r, face.bright, ink.ink); disc([at[0] - 0.35 * r, at[1] - 0.35 * r], 0.28 * r, ink.side); break;
    case "E": box(face, at, axes, [2.1 * r, 2.1 * r, 0.3 * r]); break;
    case "fixed": trace([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => [at[0] + 0.55 * r * x, at[1] + 0.55 * r * y]), true); fill(ink.ink); break;
    default: pen.beginPath(); pen.arc(at[0], at[1], 1.2 * r, 0, 2 * Math.PI); stroke(ink.ink, 1.3, [2.5, 2.5]);
  }
};
// A line with short strokes on its right side: the ground.
const hatched = (a, b) => {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1e-9, u = (b[0] - a[0]) / length, v = (b[1] - a[1]) / length;
  segment(a, b, ink.mark, 2);
  const count = Math.min(80, Math.max(2, Math.round(length / 6)));
  for (let k = 0; k < count; k++) {
    const t = (k + 0.7) / count * length, foot = [a[0] + u * t, a[1] + v * t];
    segment(foot, [foot[0] - 5 * u - 6 * v, foot[1] - 5 * v + 6 * u], ink.mark, 1);
  }
};
// A zigzag between two points with straight ends: a spring.
const zigzag = (a, b, half, colour, dash) => {
  const x = b[0] - a[0], y = b[1] - a[1], length = Math.hypot(x, y) || 1e-9;
  const at = (along, across) => [a[0] + along * x - across * half * y / length, a[1] + along * y + across * half * x / length];
  const teeth = Array.from({ length: 10 }, (_, k) => at(0.2 + 0.06 * (k + 0.5), k % 2 ? -1 : 1));
  trace([a, at(0.2, 0), ...teeth, at(0.8, 0), b]);
  pen.lineJoin = "round"; stroke(ink.paper, 3.6); stroke(colour, 1.6, dash);
  [a, b].forEach(end => disc(end, 2, colour));
};
// An arrow that stays visible on any ground.
const arrow = (from, to, colour, width = 2.4) => {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length < 2) return;
  const u = (to[0] - from[0]) / length, v = (to[1] - from[1]) / length, head = Math.min(10, 0.6 * length + 2);
  const neck = [to[0] - 0.8 * head * u, to[1] - 0.8 * head * v], wing = 0.42 * head;
  const tip = [to, [to[0] - head * u - wing * v, to[1] - head * v + wing * u], [to[0] - head * u + wing * v, to[1] - head * v - wing * u]];
  trace([from, neck]); stroke(ink.paper, width + 3);
  trace(tip, true); stroke(ink.paper, 3);
  trace([from, neck]); stroke(colour, width);
  trace(tip, true); fill(colour);
};
