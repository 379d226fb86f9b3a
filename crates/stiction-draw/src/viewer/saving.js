// What is visible, as files: the picture as SVG, the values of the samples as CSV.

// Records the calls of a drawing in place of the canvas.
const recorder = measure => {
  const parts = [], state = { lineWidth: 1, lineCap: "butt", lineJoin: "miter", globalAlpha: 1 };
  let path = "", dash = [];
  const number = x => Number(x.toFixed(2));
  const escaped = text => text.replace(/[&<>"]/g, c => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
  const opacity = () => state.globalAlpha < 1 ? ` opacity="${state.globalAlpha}"` : "";
  const lines = () => `stroke="${state.strokeStyle}" stroke-width="${state.lineWidth}" stroke-linecap="${state.lineCap}" stroke-linejoin="${state.lineJoin}"`;
  const text = (words, x, y, paint) => {
    const anchor = { center: "middle", left: "start", right: "end" }[state.textAlign] || "start";
    parts.push(`<text x="${number(x)}" y="${number(y)}" text-anchor="${anchor}" dominant-baseline="central" style="font:${escaped(state.font)}" ${paint}>${escaped(words)}</text>`);
  };
  return Object.assign(state, {
    parts,
    setTransform() {}, clearRect() {}, setLineDash(list) { dash = list; }, measureText: words => measure(state.font, words),
    beginPath() { path = ""; },
    moveTo(x, y) { path += `M${number(x)} ${number(y)}`; },
    lineTo(x, y) { path += `L${number(x)} ${number(y)}`; },
    closePath() { path += "Z"; },
    arc(x, y, r, from, to) { this.ellipse(x, y, r, r, 0, from, to); },
    // Arcs of at most a third of a turn, which the format describes without doubt.
    ellipse(x, y, rx, ry, turn, from, to) {
      const at = angle => {
        const [a, b] = [rx * Math.cos(angle), ry * Math.sin(angle)];
        return `${number(x + a * Math.cos(turn) - b * Math.sin(turn))} ${number(y + a * Math.sin(turn) + b * Math.cos(turn))}`;
      };
      const steps = Math.max(1, Math.ceil(Math.abs(to - from) / 2));
      path += `${path ? "L" : "M"}${at(from)}`;
      for (let k = 1; k <= steps; k++) path += `A${number(rx)} ${number(ry)} ${number(turn * 180 / Math.PI)} 0 ${to > from ? 1 : 0} ${at(from + (to - from) * k / steps)}`;
    },
    fill() { parts.push(`<path d="${path}" fill="${state.fillStyle}"${opacity()}/>`); },
    stroke() { parts.push(`<path d="${path}" fill="none" ${lines()}${dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : ""}${opacity()}/>`); },
    strokeText(words, x, y) { text(words, x, y, `fill="none" ${lines()}`); },
    fillText(words, x, y) { text(words, x, y, `fill="${state.fillStyle}"`); },
  });
};

const pictureAsSvg = () => {
  const canvasPen = pen;
  const recording = recorder((font, words) => { canvasPen.font = font; return canvasPen.measureText(words); });
  pen = recording;
  try { draw(); } finally { pen = canvasPen; }
  const meshes = shading.image && state.shaded ? `<image width="${room.width}" height="${room.height}" href="${shading.image()}"/>\n` : "";
  const box = `${room.width} ${room.height}`;
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${box}" width="${room.width}" height="${room.height}">\n`
    + `<rect width="100%" height="100%" fill="${ink.paper}"/>\n${meshes}${recording.parts.join("\n")}\n</svg>\n`;
};

// Values of the selected joint, or all, at the kept samples, with full precision; of two runs one below the other.
const valuesAsCsv = () => {
  const name = state.joint < 0 ? "" : scene.joints[state.joint].name, together = shownRuns();
  const names = together.map(own => own.film.columns.filter(column => !name || column.startsWith(`${name}.`)));
  const columns = [...new Set(names.flat())], cell = text => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  const labelled = others.length > 0;
  const rows = [[...(labelled ? ["run"] : []), "time [s]", ...columns].map(cell).join(",")];
  for (const own of together) {
    const places = columns.map(column => own.film.columns.indexOf(column));
    for (let f = 0; f < own.frames; f++) {
      const values = places.map(k => k < 0 ? "" : own.valueIn(k, f));
      rows.push([...(labelled ? [cell(own.label)] : []), own.times[f], ...values].join(","));
    }
  }
  return `${rows.join("\n")}\n`;
};

const save = (content, kind, ending) => {
  const address = URL.createObjectURL(new Blob([content], { type: kind }));
  const about = state.joint < 0 ? "robot" : scene.joints[state.joint].name;
  make("a", { href: address, download: `${about}.${ending}` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
};
