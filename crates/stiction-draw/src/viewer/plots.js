// Plots over time. Their numbers are attributes, and a place in them is that of the pointer.
const number = (element, name) => Number(element.getAttribute(`data-${name}`));
const placeIn = (svg, event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
// The cursor of every plot over time; a click in a plot sets the time.
const plots = [...document.querySelectorAll("svg[data-left]")].map(svg => {
  const [left, right, first, end] = ["left", "right", "first", "end"].map(name => number(svg, name));
  const heights = [...svg.querySelectorAll("g.panel")].map(panel => [number(panel, "top"), number(panel, "bottom")]);
  const mark = document.createElementNS(SPACE, "path");
  mark.setAttribute("class", "cursor");
  svg.append(mark);
  svg.addEventListener("click", event => {
    setPlaying(false);
    show(nearestFrame(first + (end - first) * (placeIn(svg, event).x - left) / (right - left)));
    remember();
  });
  return () => {
    const x = left + (right - left) * (times[state.frame] - first) / (end - first || 1);
    mark.setAttribute("d", x >= left - 0.5 && x <= right + 0.5 ? heights.map(([top, bottom]) => `M${x.toFixed(1)} ${top}V${bottom}`).join("") : "");
  };
});

// The place of the body in every plot of paths, in the run of the controls and in the one that is laid over it; a click
// near a path sets the time.
const plans = [...document.querySelectorAll("svg[data-plan]")].map(svg => {
  const panels = [...svg.querySelectorAll("g.panel")].map(panel => {
    const [left, right, top, bottom, first, end, low, high, body, across, up] =
      ["left", "right", "top", "bottom", "first", "end", "low", "high", "body", "across", "up"].map(name => number(panel, name));
    const position = (own, frame) => plus(own.poseAt(frame, body).position, film.origin);
    const at = (own, frame) => {
      const p = position(own, frame);
      return [left + (right - left) * (p[across] - first) / (end - first), bottom - (bottom - top) * (p[up] - low) / (high - low)];
    };
    // The run and the sample drawn nearest to a place, if it is near.
    const nearest = (place, near) => {
      let found, least = near;
      for (const own of [run, ...others]) for (let frame = 0; frame < own.frames; frame++) {
        const [x, y] = at(own, frame), away = Math.hypot(x - place.x, y - place.y);
        if (away < least) [found, least] = [[own, frame], away];
      }
      return found;
    };
    const contains = place => left <= place.x && place.x <= right && top <= place.y && place.y <= bottom;
    const names = [["across-name", across], ["name", up]].map(([name, axis]) => [panel.getAttribute(`data-${name}`), axis]);
    return { position, at, nearest, contains, names, range: end - first };
  });
  const marks = ["cursor other", "cursor"].map(name => {
    const mark = document.createElementNS(SPACE, "path");
    mark.setAttribute("class", name);
    svg.append(mark);
    return mark;
  });
  svg.addEventListener("click", event => {
    const place = placeIn(svg, event), panel = panels.find(own => own.contains(place));
    const found = panel && panel.nearest(place, 40);
    if (!found) return;
    const [own, frame] = found;
    setPlaying(false);
    show(nearestFrame(own.times[frame]));
    remember();
  });
  const rings = own => own ? panels.map(panel => {
    const [x, y] = panel.at(own, sampleOf(own)).map(value => value.toFixed(1));
    return `M${x - 5} ${y}a5 5 0 1 0 10 0a5 5 0 1 0 -10 0`;
  }).join("") : "";
  plots.push(() => [others[state.other], run].forEach((own, k) => marks[k].setAttribute("d", rings(own))));
  return [svg, panels];
});

// A plot under the pointer: the values of its curves there, as far as a plot can be read.
const hint = make("div", { class: "hint", "aria-hidden": "true" });
document.body.append(hint);
// Height of a drawn curve at x; undefined where it has none.
const heightAt = (path, x) => {
  path.corners ||= path.getAttribute("d").split("M").slice(1).map(part => part.split("L").map(p => p.split(" ").map(Number)));
  for (const corners of path.corners) for (let k = 1; k < corners.length; k++) {
    const [a, b] = [corners[k - 1], corners[k]];
    if (a[0] <= x && x <= b[0]) return b[0] > a[0] ? a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]) : b[1];
  }
};
// A thousandth of the axis: a plot has no more.
const read = (value, range) => { const unit = 10 ** Math.floor(Math.log10(range) - 3); return shown(Math.round(value / unit) * unit); };
// Places the hint beside the pointer.
const place = event => {
  const wide = hint.offsetWidth, room = document.documentElement.clientWidth;
  hint.style.left = `${Math.max(4, Math.min(event.clientX + 14, room - wide - 4)) + window.scrollX}px`;
  hint.style.top = `${event.clientY + 16 + window.scrollY}px`;
};
// Run, time and position of the sample of a path that is nearest to the pointer.
const tellPath = (svg, panels, event) => {
  const at = placeIn(svg, event), panel = panels.find(own => own.contains(at));
  const found = panel && panel.nearest(at, 40);
  hint.replaceChildren();
  if (!found) return;
  const [own, frame] = found;
  hint.append(make("div", {}, `${others.length ? `${own.label}, ` : ""}t = ${shown(own.times[frame])} s`));
  for (const [name, axis] of panel.names) {
    const [label, unit] = [name.replace(/ \[.*$/, ""), (/\[(.*)\]$/.exec(name) || ["", ""])[1]];
    hint.append(make("div", {}, `${label} ≈ ${read(panel.position(own, frame)[axis], panel.range)} ${unit}`));
  }
  place(event);
};
const tell = (svg, event) => {
  const at = placeIn(svg, event), [left, right] = [number(svg, "left"), number(svg, "right")];
  const panel = [...svg.querySelectorAll("g.panel")].find(own => number(own, "top") <= at.y && at.y <= number(own, "bottom"));
  hint.replaceChildren();
  if (!panel || at.x < left || at.x > right) return;
  const [top, bottom, low, high] = ["top", "bottom", "low", "high"].map(name => number(panel, name));
  const [first, end] = [number(svg, "first"), number(svg, "end")];
  hint.append(make("div", {}, `t ≈ ${read(first + (end - first) * (at.x - left) / (right - left), end - first)} s`));
  const unit = (/\[(.*)\]$/.exec(panel.getAttribute("data-name")) || ["", ""])[1];
  for (const path of panel.querySelectorAll("path[data-label]")) {
    const y = heightAt(path, at.x);
    if (y === undefined) continue;
    const line = make("div"), label = path.getAttribute("data-label") || panel.getAttribute("data-name").replace(/ \[.*$/, "");
    line.style.color = path.getAttribute("stroke");
    line.textContent = `${label} ≈ ${read(low + (high - low) * (bottom - y) / (bottom - top), high - low)} ${unit}`;
    hint.append(line);
  }
  place(event);
};
// Enlarges a plot in its frame, about a point of the window; by keys about its middle.
const enlarge = (svg, factor, event) => {
  const frame = svg.parentElement, before = frame.getBoundingClientRect(), old = Number(svg.dataset.zoom || 1);
  const zoom = Math.min(16, Math.max(1, old * factor));
  const [x, y] = event ? [event.clientX - before.left, event.clientY - before.top] : [before.width / 2, before.height / 2];
  if (old === 1) frame.style.height = `${before.height}px`;
  svg.dataset.zoom = String(zoom);
  svg.style.width = zoom > 1 ? `${100 * zoom}%` : "";
  svg.style.maxHeight = zoom > 1 ? "none" : "";
  frame.style.overflow = zoom > 1 ? "auto" : "";
  if (zoom === 1) frame.style.height = "";
  frame.scrollLeft = (frame.scrollLeft + x) * zoom / old - x;
  frame.scrollTop = (frame.scrollTop + y) * zoom / old - y;
};
for (const svg of document.querySelectorAll("svg[data-left],svg[data-plan]")) {
  const plan = plans.find(([own]) => own === svg);
  svg.addEventListener("pointermove", event => {
    if (event.pointerType !== "mouse") return;
    if (plan) tellPath(...plan, event); else tell(svg, event);
  });
  svg.addEventListener("pointerleave", () => hint.replaceChildren());
  svg.addEventListener("wheel", event => { if (event.ctrlKey) { event.preventDefault(); enlarge(svg, event.deltaY < 0 ? 1.25 : 0.8, event); } }, { passive: false });
  svg.parentElement.addEventListener("keydown", event => {
    const factor = { "+": 1.5, "-": 1 / 1.5, Escape: 0 }[event.key];
    if (factor === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
    enlarge(svg, factor);
    event.preventDefault();
  });
}

