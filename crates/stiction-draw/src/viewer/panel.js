// Controls and the link.
const controls = figure.querySelector(".controls");
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
const span = times[frames - 1] - times[0];
const speeds = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 1000];
let speed = speeds.find(s => span / s <= 8) || 1000, playing = false, clock = 0, last = 0;

const button = (text, label, act) => {
  const element = make("button", { type: "button", "aria-label": label, title: label }, text);
  element.addEventListener("click", act);
  return element;
};
const choice = (label, list, chosen, act) => {
  const box = make("select", { "aria-label": label });
  for (const [value, text] of list) {
    const option = make("option", { value }, text);
    option.selected = String(value) === String(chosen);
    box.append(option);
  }
  box.addEventListener("change", () => act(box.value));
  return box;
};
const switchOf = (key, text) => {
  const label = make("label"), box = make("input", { type: "checkbox" });
  box.checked = state[key];
  box.addEventListener("change", () => { state[key] = box.checked; draw(); });
  label.append(box, text);
  return label;
};

// The motion belongs to one sample, which is shown with it.
const ghostSwitch = () => {
  const label = switchOf("ghost", "least constrained motion");
  label.querySelector("input").addEventListener("change", () => {
    if (state.ghost) { setPlaying(false); show(ghostFrame); }
    key();
  });
  return label;
};

const play = button("▶", "play", () => setPlaying(!playing));
const slider = make("input", { type: "range", min: "0", max: String(frames - 1), step: "1", value: "0", "aria-label": "time" });
const now = make("output", { class: "now" });
const joints = choice("joint", [[-1, "joint …"], ...scene.joints.map((joint, k) => [k, joint.name])], -1, value => select(Number(value)));

const remember = () => {
  const parts = [`t=${times[state.frame]}`];
  if (state.joint >= 0) parts.push(`joint=${encodeURIComponent(scene.joints[state.joint].name)}`);
  if (camera.fitted) { if (camera.fitted !== "best") parts.push(`view=${camera.fitted}`); }
  else parts.push(`view=${[...camera.toward, ...camera.up].map(x => x.toFixed(3)).join(",")}`);
  if (state.other !== (others.length ? 0 : -1)) parts.push(`overlay=${state.other < 0 ? "" : encodeURIComponent(others[state.other].label)}`);
  if (camera.zoom !== 1) parts.push(`zoom=${camera.zoom.toFixed(2)}`);
  // A page within another document has no link of its own.
  try { history.replaceState(null, "", `#${parts.join("&")}`); } catch { /* nothing to remember */ }
};
const recall = () => {
  const parts = new Map(location.hash.slice(1).split("&").map(part => { const k = part.indexOf("="); return [part.slice(0, k), part.slice(k + 1)]; }));
  const number = key => parts.has(key) && Number.isFinite(Number(parts.get(key))) ? Number(parts.get(key)) : null;
  if (number("t") !== null) { setPlaying(false); show(nearestFrame(number("t"))); }
  const nameIn = key => { try { return decodeURIComponent(parts.get(key)); } catch { return ""; /* not a name */ } };
  if (parts.has("overlay")) layOver(others.findIndex(own => own.label === nameIn("overlay")));
  if (parts.has("joint")) {
    const name = nameIn("joint"), index = scene.joints.findIndex(joint => joint.name === name);
    if (index >= 0 && index !== state.joint) select(index);
  }
  if (number("zoom") > 0) camera.zoom = Math.min(20, Math.max(0.2, number("zoom")));
  const view = parts.get("view");
  if (view) {
    const numbers = view.split(",").map(Number);
    if (numbers.length === 6 && numbers.every(Number.isFinite) && norm(numbers.slice(0, 3)) > 0) { look(numbers.slice(0, 3), numbers.slice(3)); fit(); camera.fitted = ""; draw(); }
    else if (scene.views.some(own => own.name === view)) setView(view, false);
  }
};

const show = frame => {
  state.frame = Math.min(frames - 1, Math.max(0, frame));
  slider.value = String(state.frame);
  const other = state.other >= 0 ? others[state.other] : run, otherTime = other.times[sampleOf(other)];
  // The other run is shown at its nearest sample, or at its end.
  const text = `t = ${shown(times[state.frame])} s${otherTime === times[state.frame] ? "" : `, ${other.label} at ${shown(otherTime)} s`}`;
  slider.setAttribute("aria-valuetext", text);
  now.textContent = text;
  figure.setAttribute("data-time", String(times[state.frame]));
  draw();
  cells.forEach(cell => cell());
  cursors.forEach(cursor => cursor());
  plots.forEach(plot => plot());
};
const select = index => {
  state.joint = index;
  joints.value = String(index);
  tellOf(index);
  show(state.frame);
  remember();
};
// Lays another run over the robot; none for -1.
const layOver = index => {
  state.other = index;
  overlay.value = String(index);
  tellOf(state.joint);
  key();
  show(state.frame);
};
const overlay = choice("overlay", [[-1, "overlay: none"], ...others.map((own, k) => [k, `overlay: ${own.label}`])], state.other, value => { layOver(Number(value)); remember(); });
const setPlaying = on => {
  if (on === playing || on && frames < 2) return;
  playing = on;
  play.textContent = on ? "❚❚" : "▶";
  play.setAttribute("aria-label", on ? "pause" : "play");
  play.title = on ? "pause" : "play";
  if (!on) { remember(); return; }
  if (state.frame === frames - 1) show(0);
  clock = times[state.frame]; last = performance.now();
  const step = instant => {
    if (!playing) return;
    clock += Math.min(0.25, (instant - last) / 1000) * speed; last = instant;
    if (clock > times[frames - 1]) {
      // A reader who asked for little motion gets the motion once.
      if (calm.matches) { show(frames - 1); setPlaying(false); return; }
      clock = times[0];
    }
    const frame = frameOf(clock);
    if (frame !== state.frame) show(frame);
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
};
const setView = (name, keep = true) => {
  const view = scene.views.find(own => own.name === name), from = { toward: camera.toward, up: camera.up };
  look(view.toward, view.up);
  camera.zoom = keep ? 1 : camera.zoom; camera.fitted = name; fit(); size = symbolSize();
  const target = { toward: camera.toward, up: camera.up };
  if (calm.matches || !keep) { draw(); return; }
  // A short turn shows how both views belong together.
  const begun = performance.now();
  const turn = instant => {
    const t = Math.min(1, (instant - begun) / 350), s = t * t * (3 - 2 * t);
    const blend = (a, b) => plus(times3(a, 1 - s), times3(b, s));
    if (camera.fitted !== name) return;
    if (norm(blend(from.toward, target.toward)) > 0.05) look(blend(from.toward, target.toward), blend(from.up, target.up));
    if (t < 1) requestAnimationFrame(turn); else look(target.toward, target.up);
    draw();
  };
  requestAnimationFrame(turn);
  remember();
};
const zoom = factor => { camera.zoom = Math.min(20, Math.max(0.2, camera.zoom * factor)); draw(); remember(); };

slider.addEventListener("input", () => { setPlaying(false); show(Number(slider.value)); });
slider.addEventListener("change", remember);
const speedChoice = choice("speed", speeds.map(s => [s, `${s} ×`]), speed, value => { speed = Number(value); });
const line = (...parts) => { const row = make("div", { class: "row" }); row.append(...parts); return row; };
if (frames > 1) controls.append(line(play, slider, now, speedChoice));
const views = [["best", "iso"], ["front", "front"], ["side", "side"], ["top", "top"]].map(([name, text]) => {
  const shown = scene.planar && name === "best" ? "face-on" : text;
  return button(shown, `view: ${shown}`, () => setView(name));
});
controls.append(line(...views, button("−", "zoom out", () => zoom(0.8)), button("+", "zoom in", () => zoom(1.25)), joints, ...(others.length ? [overlay] : []),
  choice("colour of the joints", [["legs", "colour: driven"], ...(film.interfaces.length ? [["power", "colour: friction power"], ["slip", "colour: stick or slip"]] : [])], "legs", value => { state.colour = value; key(); draw(); })));
controls.append(line(...[["reactions", "reactions"], ["drives", "efforts"], ["loads", "loads"], ["com", "centre of mass"], ["names", "names"]]
  .filter(([own]) => own !== "loads" || most.load > 0).filter(([own]) => own !== "drives" || film.actuators.length)
  .filter(([own]) => own !== "reactions" || most.reaction > 0).map(([own, text]) => switchOf(own, text)),
  ...(ghostFrame >= 0 ? [ghostSwitch()] : []),
  button("save picture", "save picture as SVG", () => save(pictureAsSvg(), "image/svg+xml", "svg")),
  ...(film.columns.length ? [button("save values", "save values of the selected joint, or of all, as CSV", () => save(valuesAsCsv(), "text/csv", "csv"))] : [])));
const meaning = make("p", { class: "key note" });
controls.append(meaning);
const key = () => {
  const ghost = state.ghost ? `Dashed, at t = ${shown(times[ghostFrame])} s: the motion that the robot resists least with its actuators held (singularity index ${shown(film.ghost.index)}). ` : "";
  const other = state.other >= 0 ? `In colours: ${run.label}. Grey and dashed: ${others[state.other].label}. ` : "";
  meaning.textContent = ghost + other + (state.colour === "power" ? `From white, no friction power, to red, ${shown(most.power)} W, by its square root.`
    : state.colour === "slip" ? "Blue: at rest. Red: slides. Yellow: some of its interfaces at rest." : "");
};

// Drag, pinch, click and keys on the picture.
const touches = new Map();
let moved = 0;
canvas.addEventListener("pointerdown", event => {
  canvas.setPointerCapture(event.pointerId);
  touches.set(event.pointerId, [event.offsetX, event.offsetY]); moved = 0;
});
const nearest = (x, y) => {
  let best = -1, least = 26;
  spots.forEach((p, k) => { const gap = Math.hypot(p[0] - x, p[1] - y); if (gap < least) [best, least] = [k, gap]; });
  return best;
};
canvas.addEventListener("pointermove", event => {
  const before = touches.get(event.pointerId), at = [event.offsetX, event.offsetY];
  if (!before) {
    const hover = nearest(...at);
    if (hover !== state.hover) { state.hover = hover; canvas.style.cursor = hover < 0 ? "grab" : "pointer"; draw(); }
    return;
  }
  const others = [...touches].filter(([id]) => id !== event.pointerId);
  if (others.length) {
    const gap = point => Math.hypot(point[0] - others[0][1][0], point[1] - others[0][1][1]);
    if (gap(before) > 10) camera.zoom = Math.min(20, Math.max(0.2, camera.zoom * gap(at) / gap(before)));
    moved = 99;
  } else {
    moved += Math.hypot(at[0] - before[0], at[1] - before[1]);
    if (moved > 4) orbit((at[0] - before[0]) * 0.01, (before[1] - at[1]) * -0.01);
  }
  touches.set(event.pointerId, at);
  draw();
});
canvas.addEventListener("pointerup", event => {
  touches.delete(event.pointerId);
  if (moved <= 4) { const index = nearest(event.offsetX, event.offsetY); if (index >= 0 || state.joint >= 0) select(index); } else remember();
});
canvas.addEventListener("pointercancel", event => touches.delete(event.pointerId));
canvas.addEventListener("pointerleave", () => { if (state.hover >= 0) { state.hover = -1; draw(); } });
canvas.addEventListener("wheel", event => { if (event.ctrlKey) { event.preventDefault(); zoom(event.deltaY < 0 ? 1.1 : 0.9); } }, { passive: false });
canvas.addEventListener("keydown", event => {
  const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
  if (event.altKey || event.ctrlKey || event.metaKey) return;
  if (turns[event.key]) { orbit(...turns[event.key]); draw(); remember(); }
  else if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 1.25 : 0.8);
  else if (event.key === " ") setPlaying(!playing);
  else if (event.key === "Escape") select(-1);
  else return;
  event.preventDefault();
});

document.documentElement.classList.add("live");
const kept = figure.querySelector(".kept");
kept.append(film.columns.length ? ` Click a joint for its reaction and friction${others.length ? " in both runs" : ""}.` : " Drag to turn it.");
// What the script of the shaded view needs, and how it joins.
if (film.meshes.length) figure.shading = {
  film, camera, room,
  poseOf: body => run.poseAt(state.frame, body),
  colourOf: body => legColour(scene.bodies[body].leg),
  fail(text) { kept.append(` ${text}`); },
  begin({ canvas: below, bodies, corners, draw: drawMeshes, image }) {
    canvas.after(below);
    Object.assign(shading, { draw: drawMeshes, image, bodies: new Set(bodies) });
    for (const frame of some) for (const [body, point] of corners) extent.push(placed(frame, body, point));
    controls.insertBefore(line(switchOf("shaded", "meshes")), meaning);
    resize();
  },
};
if (frames < film.of) kept.append(` ${frames} of ${film.of} samples are kept here, among them all peaks of the tables; the cursor snaps to them.`);
const resize = () => {
  const box = canvas.parentElement.getBoundingClientRect();
  if (!(box.width > 0)) return;
  room.width = box.width; room.height = Math.round(Math.min(560, Math.max(300, 0.62 * box.width)));
  const ratio = Math.min(3, window.devicePixelRatio || 1);
  canvas.width = Math.round(room.width * ratio); canvas.height = Math.round(room.height * ratio);
  canvas.style.height = `${room.height}px`;
  fit(); size = symbolSize(); draw();
};
refreshColours();
const first = scene.views[0];
look(first.toward, first.up);
new ResizeObserver(resize).observe(canvas.parentElement);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { refreshColours(); draw(); });
window.addEventListener("hashchange", recall);
resize();
key();
show(0);
recall();
