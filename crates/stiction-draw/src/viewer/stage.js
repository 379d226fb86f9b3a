// The picture at a sample.
const state = { frame: 0, joint: -1, hover: -1, colour: "legs", reactions: false, drives: true, loads: true, com: false, names: false, ghost: false, shaded: true, other: others.length ? 0 : -1 };
let spots = [];

// Largest values along all runs, to which arrows and colours are scaled.
const greatest = list => {
  let most = 0;
  for (const own of [run, ...others]) for (let f = 0; f < own.frames; f++) most = Math.max(most, list(own, f));
  return Number.isFinite(most) ? most : 0;
};
const forceAt = (own, joint, frame) => own.vectorAt(joint.name, "f", frame);
const effortAt = (own, actuator, frame) => own.valueAt(`${actuator.name}.drive`, frame) || 0;
const efforts = turns => greatest((own, f) => Math.max(0, ...own.film.actuators.filter(a => a.turns === turns).map(a => Math.abs(effortAt(own, a, f)))));
const powers = scene.joints.map((joint, k) => film.interfaces.filter(own => own[1] === k).map(own => own[0]));
const powerAt = (joint, frame) => powers[joint].reduce((sum, name) => sum + (valueAt(`${name}.power`, frame) || 0), 0);
const most = {
  reaction: greatest((own, f) => Math.max(0, ...own.scene.joints.map(joint => norm(forceAt(own, joint, f))))),
  force: efforts(false),
  torque: efforts(true),
  load: greatest((own, f) => Math.max(0, ...own.loaded.map(k => norm(own.loadAt(f, k))))),
  power: greatest((own, f) => own === run ? Math.max(0, ...scene.joints.map((_, k) => powerAt(k, f))) : 0),
};

const mixed = (a, b, t) => {
  const part = (colour, k) => parseInt(colour.slice(1 + 2 * k, 3 + 2 * k), 16);
  return `rgb(${[0, 1, 2].map(k => Math.round(part(a, k) + (part(b, k) - part(a, k)) * t)).join(",")})`;
};
const faceOf = (index, frame) => {
  const joint = scene.joints[index];
  const plain = joint.driven ? { bright: ink.drive, dim: ink.driveside } : { bright: ink.paper, dim: ink.side };
  if (state.colour === "power") {
    if (!powers[index].length) return { bright: ink.paper, dim: ink.side };
    const t = most.power > 0 ? Math.sqrt(Math.max(0, powerAt(index, frame)) / most.power) : 0;
    return { bright: mixed(ink.paper, ink.bad, t), dim: mixed(ink.side, ink.bad, t) };
  }
  if (state.colour === "slip") {
    const own = powers[index].map(name => valueAt(`${name}.sticks`, frame)).filter(x => x !== undefined);
    if (!own.length) return { bright: ink.paper, dim: ink.side };
    const colour = own.every(x => x === 1) ? ink.link : own.some(x => x === 1) ? ink.open : ink.bad;
    return { bright: colour, dim: mixed(colour, ink.side, 0.35) };
  }
  return plain;
};
// Name of the colour of a leg; there are seven.
const legName = leg => `leg${leg % 7}`;
const legColour = leg => leg === null ? ink.hubedge : ink[legName(leg)];
const WIDTHS = { bone: 6, tube: 9, stem: 4.5 };

// Outline of a body at a sample: the hull of its joints, and of its centre of mass if it has one joint only.
const outlineOf = (own, k, frame, places) => {
  const body = own.scene.bodies[k], points = [];
  for (const joint of body.joints) {
    const p = project(places[joint]);
    if (points.every(q => Math.hypot(p[0] - q[0], p[1] - q[1]) > 0.5)) points.push(p);
  }
  const middle = project(own.placed(frame, k, body.com));
  const alone = points.length < 2 && body.mass > 0 && points.every(q => Math.hypot(middle[0] - q[0], middle[1] - q[1]) > 2);
  if (alone) points.push(middle);
  return { outline: hull(points), middle, alone };
};
const drawBody = (k, frame, places) => {
  if (isShaded(k)) return;
  const body = scene.bodies[k], { outline, middle, alone } = outlineOf(run, k, frame, places), colour = legColour(body.leg);
  if (outline.length > 2) {
    trace(outline, true); fill(ink.hub, 0.5); pen.lineJoin = "round"; stroke(colour, 2);
  } else if (outline.length === 2) {
    pen.lineCap = "round";
    segment(outline[0], outline[1], ink.paper, WIDTHS[body.line] + 3);
    segment(outline[0], outline[1], colour, WIDTHS[body.line]);
    pen.lineCap = "butt";
  }
  if (alone || !outline.length) disc(middle, 3, ink.ink);
};
const drawPath = (own, point, colour) => {
  const step = Math.max(1, Math.floor(own.frames / 600)), path = [];
  for (let f = 0; f < own.frames; f += step) path.push(project(own.placed(f, point.body, point.at)));
  path.push(project(own.placed(own.frames - 1, point.body, point.at)));
  pen.globalAlpha = 0.65; trace(path); stroke(colour, 1.6); pen.globalAlpha = 1;
};
// Another run at the same time: outlines, joints, paths and arrows, grey and dashed as in plots.
const drawOther = own => {
  const frame = own.nearestFrame(times[state.frame]), places = own.scene.joints.map(joint => own.jointAt(frame, joint));
  own.scene.traced.forEach(point => drawPath(own, point, ink.soft));
  own.scene.bodies.forEach((_, k) => {
    if (!k) return;
    const { outline, middle } = outlineOf(own, k, frame, places);
    if (outline.length < 2) { disc(middle, 3, ink.soft); return; }
    trace(outline, outline.length > 2); stroke(ink.paper, 4, [7, 4]); stroke(ink.soft, 2, [7, 4]);
  });
  own.scene.springs.forEach(spring => zigzag(...own.endsOf(frame, spring).map(project), 0.8 * size, ink.soft, [7, 4]));
  places.forEach(place => disc(project(place), 2.6, ink.soft, ink.paper));
  arrowsAt(own, frame, places);
};

// Range of each slide on the ground, as points of the world.
const rails = scene.joints.map(joint => {
  if (joint.from !== 0 || !"PC".includes(joint.type)) return null;
  const axis = turned(0, 0, joint.axes[2]), first = jointAt(0, joint);
  const along = some.map(frame => dot(minus(jointAt(frame, joint), first), axis));
  return { axis, from: plus(first, times3(axis, Math.min(...along))), to: plus(first, times3(axis, Math.max(...along))) };
});
const groundMark = (index, frame, at, places) => {
  const joint = scene.joints[index];
  if (joint.from && joint.to || joint.type === "free") return;
  const rail = rails[index];
  if (rail) {
    let [x, y] = flat(rail.axis);
    const across = Math.hypot(x, y);
    if (across > 0.1) {
      let a = project(rail.from), b = project(rail.to);
      [x, y] = [x / across, y / across];
      if (x < 0) [x, y, a, b] = [-x, -y, b, a];
      const n = [-y * 1.25 * size, x * 1.25 * size], r = 3.2 * size;
      hatched([a[0] - x * r + n[0], a[1] - y * r + n[1]], [b[0] + x * r + n[0], b[1] + y * r + n[1]]);
      return;
    }
  }
  const other = joint.from ? joint.from : joint.to;
  const others = scene.bodies[other].joints.filter(k => k !== index).map(k => places[k]);
  const leads = others.length ? times3(others.reduce(plus), 1 / others.length) : placed(frame, other, scene.bodies[other].com);
  const hangs = project(leads)[1] > at[1] + 0.5 * norm(minus(leads, places[index])) * perMetre();
  const sign = hangs ? -1 : 1, y = at[1] + sign * 2.1 * size, a = [at[0] - 1.9 * size, y], b = [at[0] + 1.9 * size, y];
  segment(at, [at[0], y], ink.mark, 2);
  if (hangs) hatched(b, a); else hatched(a, b);
};

// Greatest of 1, 2 and 5 times a power of ten that does not exceed a number.
const round = x => { const power = 10 ** Math.floor(Math.log10(x)); return ([5, 2].find(d => d * power <= x) || 1) * power; };
const reach = () => 0.26 * Math.min(room.width, room.height);
const arrowsAt = (own, frame, places) => {
  const inkOf = colour => own === run ? colour : ink.soft, side = own === run ? 1 : -1;
  if (state.loads && most.load > 0) for (const k of own.loaded) {
    const [x, y] = flat(times3(own.loadAt(frame, k), reach() / most.load));
    const from = project(own.loadFrom(frame, k));
    arrow(from, [from[0] + x, from[1] + y], inkOf(ink.good));
  }
  if (state.reactions && most.reaction > 0) own.scene.joints.forEach((joint, k) => {
    const [x, y] = flat(times3(forceAt(own, joint, frame), reach() / most.reaction)), from = project(places[k]);
    arrow(from, [from[0] + x, from[1] + y], inkOf(ink.ink));
  });
  if (state.drives) for (const actuator of own.film.actuators) {
    const joint = own.scene.joints[actuator.joint], at = project(places[actuator.joint]), effort = effortAt(own, actuator, frame);
    const axis = actuator.second ? own.turned(frame, joint.to, joint.second) : own.turned(frame, joint.from, joint.axes[actuator.axis]);
    if (!actuator.turns && most.force > 0) {
      const [x, y] = flat(times3(axis, effort * reach() / most.force)), [u, v] = flat(axis), n = side * Math.hypot(u, v);
      // Beside the slide, so that both are visible, and those of two runs on both sides.
      const aside = n ? [-v / n * 2.2 * size, u / n * 2.2 * size] : [0, 0];
      arrow([at[0] + aside[0], at[1] + aside[1]], [at[0] + aside[0] + x, at[1] + aside[1] + y], inkOf(ink.open));
    } else if (actuator.turns && most.torque > 0) {
      turnArrow(places[actuator.joint], axis, 1.5 * Math.PI * effort / most.torque, inkOf(ink.open), own === run ? 2.7 : 3.6);
    }
  }
};
// An arc about an axis, as long as its torque is large.
const turnArrow = (centre, axis, angle, colour, radius) => {
  if (Math.abs(angle) < 0.06) return;
  const start = unit(minus(camera.up, times3(axis, dot(camera.up, axis)))), r = radius * size / perMetre();
  if (norm(cross(axis, camera.up)) < 1e-6) return;
  const steps = Math.max(4, Math.ceil(Math.abs(angle) / 0.12));
  const points = Array.from({ length: steps + 1 }, (_, k) => project(plus(centre, times3(spun(start, axis, angle * k / steps), r))));
  trace(points); stroke(ink.paper, 5.4); trace(points); stroke(colour, 2.4);
  const [a, b] = points.slice(-2), n = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1, u = [(b[0] - a[0]) / n, (b[1] - a[1]) / n];
  trace([[b[0] + 7 * u[0], b[1] + 7 * u[1]], [b[0] - 4 * u[1], b[1] + 4 * u[0]], [b[0] + 4 * u[1], b[1] - 4 * u[0]]], true); fill(colour);
};

const legend = () => {
  const base = room.height - 26;
  let highest = 0;
  ["x", "y", "z"].forEach((_, k) => { highest = Math.max(highest, -flat([0, 1, 2].map(l => l === k ? 1 : 0))[1]); });
  const at = [40, base - 4];
  ["x", "y", "z"].forEach((name, k) => {
    const [x, y, deep] = flat([0, 1, 2].map(l => l === k ? 1 : 0)), across = Math.hypot(x, y);
    if (across < 0.05) {
      pen.beginPath(); pen.arc(at[0], at[1], 5, 0, 2 * Math.PI); stroke(ink.ink, 1.1);
      if (deep > 0) disc(at, 1.8, ink.ink);
      words(name, [at[0] - 13, at[1] + 13], ink.soft);
      return;
    }
    const tip = [at[0] + 24 * x, at[1] + 24 * y], u = x / across, v = y / across;
    segment(at, tip, ink.ink, 1.1);
    if (across > 0.3) [1, -1].forEach(side => segment(tip, [tip[0] - 7 * u - side * 3.5 * v, tip[1] - 7 * v + side * 3.5 * u], ink.ink, 1.1));
    words(name, [tip[0] + 10 * u, tip[1] + 10 * v], ink.soft);
  });
  // Bars: a round length, and round forces of the arrows.
  let x = 92;
  const bar = (length, text, colour, isArrow) => {
    const wide = Math.max(length, pen.measureText(text).width);
    if (!(length > 4) || x + wide + 6 > room.width) return;
    if (isArrow) arrow([x, base], [x + length, base], colour);
    else { segment([x, base], [x + length, base], colour, 2); [x, x + length].forEach(e => segment([e, base - 5], [e, base + 5], colour, 2)); }
    words(text, [x, base - 13], colour === ink.ink ? ink.soft : colour, "left");
    x += wide + 22;
  };
  const metres = round(90 / perMetre());
  bar(metres * perMetre(), metres >= 1 ? `${shown(metres)} m` : `${shown(metres * 1e3)} mm`, ink.ink, false);
  const force = (scale, text, colour) => { if (scale > 0) { const n = round(0.75 * scale); bar(n / scale * reach(), `${text} ${shown(n)} N`, colour, true); } };
  if (state.drives) force(most.force, "effort", ink.open);
  if (state.drives && most.torque > 0) {
    const text = `effort: ¾ turn ${shown(most.torque)} N m`, wide = pen.measureText(text).width;
    if (x + wide + 6 <= room.width) { words(text, [x, base - 13], ink.open, "left"); x += wide + 22; }
  }
  if (state.reactions) force(most.reaction, "reaction", ink.ink);
  if (state.loads) force(most.load, "load", ink.good);
};

const draw = () => {
  const ratio = Math.min(3, window.devicePixelRatio || 1), frame = state.frame;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, room.width, room.height);
  if (shading.draw) shading.draw(state.shaded);
  pen.lineCap = "butt";
  const places = scene.joints.map(joint => jointAt(frame, joint)), parts = [];
  if (!scene.planar) {
    const plate = hull(scene.bodies[0].joints.map(k => project(places[k])));
    if (plate.length > 2) { trace(plate, true); fill(ink.plate, 0.35); stroke(ink.mark, 1); }
  }
  scene.bodies.forEach((body, k) => {
    if (!k) return;
    let depth = depthOf(placed(frame, k, body.com));
    for (const joint of body.joints) depth = Math.min(depth, depthOf(places[joint]));
    parts.push([depth, () => drawBody(k, frame, places)]);
  });
  spots = [];
  scene.joints.forEach((joint, k) => {
    const at = project(places[k]);
    spots.push(at);
    parts.push([depthOf(places[k]) + ("PE".includes(joint.type) ? 0.5 : 1) * size, () => {
      groundMark(k, frame, at, places);
      if (k === state.joint || k === state.hover) { pen.beginPath(); pen.arc(at[0], at[1], 2.3 * size, 0, 2 * Math.PI); fill(ink.link, 0.18); stroke(ink.link, k === state.joint ? 2.5 : 1.5); }
      symbol(joint, frame, at, faceOf(k, frame));
    }]);
  });
  scene.springs.forEach(spring => {
    const ends = run.endsOf(frame, spring);
    parts.push([Math.max(...ends.map(depthOf)), () => zigzag(...ends.map(project), 0.8 * size, ink.ink)]);
  });
  parts.sort((a, b) => a[0] - b[0]).forEach(part => part[1]());
  if (state.ghost && frame === ghostFrame) drawGhost(frame, places);
  for (const point of scene.traced) {
    drawPath(run, point, ink.hubedge);
    disc(project(placed(frame, point.body, point.at)), 3, ink.hubedge);
  }
  if (state.com) {
    let mass = 0, sum = [0, 0, 0];
    scene.bodies.forEach((body, k) => {
      if (!k || !(body.mass > 0)) return;
      const at = placed(frame, k, body.com);
      mass += body.mass; sum = plus(sum, times3(at, body.mass));
      disc(project(at), 2.6, ink.ink, ink.paper);
    });
    if (mass > 0) {
      const at = project(times3(sum, 1 / mass));
      disc(at, 7, ink.paper, ink.ink);
      [0, 2].forEach(k => { pen.beginPath(); pen.moveTo(at[0], at[1]); pen.arc(at[0], at[1], 7, k * Math.PI / 2, (k + 1) * Math.PI / 2); pen.closePath(); fill(ink.ink); });
    }
  }
  if (state.other >= 0) drawOther(others[state.other]);
  arrowsAt(run, frame, places);
  const named = state.names ? scene.joints.map((_, k) => k) : [state.joint, state.hover].filter(k => k >= 0);
  for (const k of new Set(named)) {
    const joint = scene.joints[k], half = joint.name.length * 4;
    const x = Math.min(room.width - half - 4, Math.max(half + 4, spots[k][0]));
    words(joint.name, [x, spots[k][1] - 2.3 * size - 9], joint.leg === null ? ink.ink : legColour(joint.leg));
  }
  legend();
};
