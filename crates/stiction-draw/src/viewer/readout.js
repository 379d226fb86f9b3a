// What is known of the selected joint at the sample, with full precision in `data-value`, and its curves.
const readout = figure.querySelector(".readout");
const SPACE = "http://www.w3.org/2000/svg";
let cells = [], cursors = [];

// The least and the greatest value of each of at most some hundred intervals of a run.
const thinned = (own, list) => {
  const step = Math.max(1, Math.ceil(own.frames / 400)), kept = [];
  for (let from = 0; from < own.frames; from += step) {
    let low = from, high = from;
    for (let f = from; f < Math.min(own.frames, from + step); f++) {
      if (list(own, f) < list(own, low)) low = f;
      if (list(own, f) > list(own, high)) high = f;
    }
    kept.push(...(low === high ? [low] : [Math.min(low, high), Math.max(low, high)]));
  }
  return kept.map(f => [own.times[f], list(own, f)]).filter(([, y]) => Number.isFinite(y));
};
const shownRuns = () => [run, ...(state.other >= 0 ? [others[state.other]] : [])];
// The colour of the selected joint's leg, as in the picture and in plots of actuators.
const ownColour = () => { const leg = scene.joints[state.joint]?.leg; return leg === null || leg === undefined ? "var(--line0)" : `var(--${legName(leg)})`; };
const curve = (title, unit, list) => {
  const lines = shownRuns().map(own => thinned(own, list)).filter(points => points.length > 1), all = lines.flat();
  if (!all.length) return null;
  const [first, end, low, high] = [0, 1].flatMap(k => [Math.min(...all.map(p => p[k])), Math.max(...all.map(p => p[k]))]);
  const W = 300, H = 96, left = 8, right = 292, top = 24, bottom = 74;
  const x = t => left + (right - left) * (t - first) / (end - first || 1);
  const y = v => high > low ? bottom - (bottom - top) * (v - low) / (high - low) : 0.5 * (top + bottom);
  const part = (name, attributes, text = "") => {
    const element = document.createElementNS(SPACE, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    element.textContent = text;
    return element;
  };
  const svg = part("svg", { viewBox: `0 0 ${W} ${H}`, class: "joint-curve", style: `--own:${ownColour()}`, role: "img", "aria-label": `${title} over time` });
  const label = (text, at, height, anchor, kind) => part("text", { x: at, y: height, "text-anchor": anchor, class: kind }, text);
  svg.append(
    label(`${title} [${unit}]`, left, 14, "start", "what"),
    part("path", { d: `M${left} ${bottom + 3}H${right}`, class: "axis" }),
    ...lines.map((points, k) => part("polyline", { points: points.map(([t, v]) => `${x(t).toFixed(1)},${y(v).toFixed(1)}`).join(" "), class: k ? "line other" : "line" })),
    label(`${shown(low)} to ${shown(high)} ${unit}`, left, 91, "start", "range"),
    label(`${shown(first)} to ${shown(end)} s`, right, 91, "end", "range"),
  );
  const line = part("path", { class: "cursor" });
  svg.append(line);
  cursors.push(() => line.setAttribute("d", `M${x(times[state.frame]).toFixed(1)} ${top - 4}V${bottom + 3}`));
  return svg;
};

// Sample of a run at the time of the cursor.
const sampleOf = own => own === run ? state.frame : own.nearestFrame(times[state.frame]);
const tellOf = index => {
  readout.replaceChildren();
  cells = []; cursors = [];
  if (index < 0) return;
  const joint = scene.joints[index], name = joint.name;
  const body = k => scene.bodies[k].name;
  readout.append(make("h3", {}, name), make("p", { class: "note" }, `${joint.word}${joint.driven ? ", driven" : ""}, ${body(joint.from)} to ${body(joint.to)}`));
  const table = make("table"), rows = make("tbody"), together = shownRuns();
  if (together.length > 1) {
    const head = make("thead"), line = make("tr");
    line.append(make("td"), ...together.map(own => make("th", { class: "number" }, own.label)), make("td"));
    head.append(line);
    table.append(head);
  }
  // A row with a cell for each run; `fill` writes the value at a sample into it.
  const row = (what, unit, fill, column) => {
    const line = make("tr"), wide = together.map((own, k) => {
      const cell = make("td", { class: "number" });
      if (column && own.columnOf.has(column)) cell.setAttribute(k ? "data-other-column" : "data-column", `${column} [${unit}]`);
      cells.push(() => fill(cell, own, sampleOf(own)));
      return cell;
    });
    line.append(make("td", {}, what), ...wide, make("td", {}, unit));
    rows.append(line);
  };
  const number = list => (cell, own, frame) => { const x = list(own, frame); cell.textContent = shown(x); cell.setAttribute("data-value", String(x)); };
  const quantity = (what, column) => row(what, unitOf.get(column) || "", number(value(column)), column);
  const value = column => (own, frame) => own.valueAt(column, frame);
  const size = letter => (own, frame) => own.columnOf.has(`${name}.fx`) ? norm(own.vectorAt(name, letter, frame)) : undefined;
  const charts = make("div", { class: "joint-curves" });
  const chart = (title, unit, list) => { const svg = curve(title, unit, list); if (svg) charts.append(svg); };
  for (const actuator of film.actuators.filter(own => own.joint === index)) {
    const column = `${actuator.name}.drive`;
    quantity(film.actuators.filter(own => own.joint === index).length > 1 ? `effort of ${actuator.name}` : "effort", column);
    for (const end of ["low", "high"]) if (run.columnOf.has(`${column}_${end}`)) {
      quantity(end === "low" ? "least effort at rest" : "greatest effort at rest", `${column}_${end}`);
    }
    chart(`effort ${actuator.name}`, actuator.unit, value(column));
  }
  if (run.columnOf.has(`${name}.fx`)) {
    for (const [letter, what] of [["f", "reaction force"], ["m", "reaction moment"]]) {
      row(`${what}, magnitude`, unitOf.get(`${name}.${letter}x`), number(size(letter)));
      for (const axis of ["x", "y", "z"]) quantity(`${letter}${axis}`, `${name}.${letter}${axis}`);
    }
    chart("reaction force", "N", size("f"));
  }
  for (const own of powers[index]) {
    for (const [what, key] of [["sliding speed", "speed"], ["normal load", "load"], ["friction", "friction"], ["dissipated power", "power"]]) {
      quantity(powers[index].length > 1 ? `${what}, ${own.slice(name.length + 1)}` : what, `${own}.${key}`);
    }
    row("state", "", (cell, of, frame) => {
      const sticks = of.valueAt(`${own}.sticks`, frame);
      cell.textContent = sticks === undefined ? "none" : sticks === 1 ? "at rest" : "slides";
    });
    chart(`friction ${own}`, "N", value(`${own}.friction`));
  }
  const determined = `${name}.determined`;
  const open = make("p", { class: "note" });
  cells.push(() => { open.textContent = valueAt(determined, state.frame) === 0 ? "Statics does not determine all components of this reaction." : ""; });
  table.append(rows);
  const wide = make("div", { class: "wide", tabindex: "0", role: "group", "aria-label": `values of ${name}` });
  wide.append(table);
  const pair = make("div", { class: "joint-values" });
  pair.append(wide, charts);
  readout.append(pair, open);
};
