// What is known of the selected joint at the sample, with full precision in `data-value`, and its curves.
const readout = figure.querySelector(".readout");
const SPACE = "http://www.w3.org/2000/svg";
let cells = [], cursors = [];

// The least and the greatest value of each of at most some hundred intervals.
const thinned = list => {
  const step = Math.max(1, Math.ceil(frames / 400)), kept = [];
  for (let from = 0; from < frames; from += step) {
    let low = from, high = from;
    for (let f = from; f < Math.min(frames, from + step); f++) {
      if (list(f) < list(low)) low = f;
      if (list(f) > list(high)) high = f;
    }
    kept.push(...(low === high ? [low] : [Math.min(low, high), Math.max(low, high)]));
  }
  return kept.filter(f => Number.isFinite(list(f)));
};
const curve = (title, unit, list) => {
  const kept = thinned(list);
  if (kept.length < 2) return null;
  const low = Math.min(...kept.map(list)), high = Math.max(...kept.map(list));
  const W = 300, H = 96, left = 8, right = 292, top = 24, bottom = 74;
  const x = f => left + (right - left) * (times[f] - times[0]) / (times[frames - 1] - times[0] || 1);
  const y = v => high > low ? bottom - (bottom - top) * (v - low) / (high - low) : 0.5 * (top + bottom);
  const part = (name, attributes, text = "") => {
    const element = document.createElementNS(SPACE, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    element.textContent = text;
    return element;
  };
  const svg = part("svg", { viewBox: `0 0 ${W} ${H}`, class: "joint-curve", role: "img", "aria-label": `${title} over time` });
  const label = (text, at, height, anchor, kind) => part("text", { x: at, y: height, "text-anchor": anchor, class: kind }, text);
  svg.append(
    label(`${title} [${unit}]`, left, 14, "start", "what"),
    part("path", { d: `M${left} ${bottom + 3}H${right}`, class: "axis" }),
    part("polyline", { points: kept.map(f => `${x(f).toFixed(1)},${y(list(f)).toFixed(1)}`).join(" "), class: "line" }),
    label(`${shown(low)} to ${shown(high)} ${unit}`, left, 91, "start", "range"),
    label(`${shown(times[0])} to ${shown(times[frames - 1])} s`, right, 91, "end", "range"),
  );
  const line = part("path", { class: "cursor" });
  svg.append(line);
  cursors.push(() => line.setAttribute("d", `M${x(state.frame).toFixed(1)} ${top - 4}V${bottom + 3}`));
  return svg;
};

const tellOf = index => {
  readout.replaceChildren();
  cells = []; cursors = [];
  if (index < 0) return;
  const joint = scene.joints[index], name = joint.name;
  const body = k => scene.bodies[k].name;
  readout.append(make("h3", {}, name), make("p", { class: "note" }, `${joint.word}${joint.driven ? ", driven" : ""}, ${body(joint.from)} to ${body(joint.to)}`));
  const table = make("table"), rows = make("tbody");
  const row = (what, column, list) => {
    const line = make("tr"), unit = unitOf.get(column) || "", cell = make("td", { class: "number" });
    if (columnOf.has(column)) cell.setAttribute("data-column", `${column} [${unit}]`);
    line.append(make("td", {}, what), cell, make("td", {}, unit));
    rows.append(line);
    cells.push(frame => { const x = list(frame); cell.textContent = shown(x); cell.setAttribute("data-value", String(x)); });
  };
  const value = column => frame => valueAt(column, frame);
  const size = letter => frame => norm(vectorAt(name, letter, frame));
  const charts = make("div", { class: "joint-curves" });
  const chart = (title, unit, list) => { const svg = curve(title, unit, list); if (svg) charts.append(svg); };
  for (const actuator of film.actuators.filter(own => own.joint === index)) {
    const column = `${actuator.name}.drive`;
    row(film.actuators.filter(own => own.joint === index).length > 1 ? `effort of ${actuator.name}` : "effort", column, value(column));
    for (const end of ["low", "high"]) if (columnOf.has(`${column}_${end}`)) {
      row(end === "low" ? "least effort at rest" : "greatest effort at rest", `${column}_${end}`, value(`${column}_${end}`));
    }
    chart(`effort ${actuator.name}`, actuator.unit, value(column));
  }
  if (columnOf.has(`${name}.fx`)) {
    for (const [letter, what] of [["f", "reaction force"], ["m", "reaction moment"]]) {
      const unit = unitOf.get(`${name}.${letter}x`);
      const line = make("tr"), cell = make("td", { class: "number" });
      line.append(make("td", {}, `${what}, magnitude`), cell, make("td", {}, unit));
      rows.append(line);
      cells.push(frame => { const x = size(letter)(frame); cell.textContent = shown(x); cell.setAttribute("data-value", String(x)); });
      for (const axis of ["x", "y", "z"]) row(`${letter}${axis}`, `${name}.${letter}${axis}`, value(`${name}.${letter}${axis}`));
    }
    chart("reaction force", "N", size("f"));
  }
  for (const own of powers[index]) {
    for (const [what, key] of [["sliding speed", "speed"], ["normal load", "load"], ["friction", "friction"], ["dissipated power", "power"]]) {
      row(powers[index].length > 1 ? `${what}, ${own.slice(name.length + 1)}` : what, `${own}.${key}`, value(`${own}.${key}`));
    }
    const line = make("tr"), cell = make("td", { colspan: "2" });
    line.append(make("td", {}, "state"), cell);
    rows.append(line);
    cells.push(frame => { cell.textContent = valueAt(`${own}.sticks`, frame) === 1 ? "at rest" : "slides"; });
    chart(`friction ${own}`, "N", value(`${own}.friction`));
  }
  const determined = `${name}.determined`;
  const open = make("p", { class: "note" });
  cells.push(frame => { open.textContent = valueAt(determined, frame) === 0 ? "Statics does not determine all components of this reaction." : ""; });
  table.append(rows);
  const wide = make("div", { class: "wide" });
  wide.append(table);
  const pair = make("div", { class: "joint-values" });
  pair.append(wide, charts);
  readout.append(pair, open);
};
