// Sliders: single values of the model that replace those of its text.

/** Largest number of sliders of one kind that a model shows at once. */
const MOST = 4;

const sliders = {
  box: byId("sliders"), keys: byId("keys"), values: new Map(), shown: [], set: new Map(), onchange: () => {},

  /** Changes of values, as `KEY = VALUE`. */
  get changes() {
    return [...this.set].map(([key, value]) => `${key} = ${value} ${this.values.get(key)?.unit ?? ""}`.trim());
  },

  /** Takes the numbers of a model; a slider stays if its value still exists. */
  take(values) {
    this.values = new Map(values.map(one => [one.key, one]));
    for (const key of [...this.set.keys()]) if (!this.values.has(key)) this.set.delete(key);
    this.shown = this.shown.filter(key => this.values.has(key));
    if (this.shown.length === 0) this.shown = this.first();
    for (const key of this.set.keys()) if (!this.shown.includes(key)) this.shown.push(key);
    this.keys.replaceChildren(...[...this.values.keys()].map(key => new Option(key)));
    this.draw();
  },

  /** Parameters, then friction coefficients and masses. */
  first() {
    const all = [...this.values.keys()];
    const kinds = [/^parameters\./, /\bmu$/, /\.mass$/];
    return [...new Set(kinds.flatMap(kind => all.filter(key => kind.test(key)).slice(0, MOST)))];
  },

  add(key) {
    if (!this.values.has(key)) return false;
    if (!this.shown.includes(key)) this.shown.push(key);
    this.draw();
    return true;
  },

  forget() { this.values = new Map(); this.shown = []; this.set.clear(); },

  draw() {
    this.box.replaceChildren(...this.shown.map(key => this.row(key)));
    if (this.shown.length === 0) this.box.textContent = "no numbers in this model";
  },

  row(key) {
    const { value, unit } = this.values.get(key);
    const row = document.createElement("div");
    row.className = "slider";
    row.dataset.key = key;
    const cell = (element, properties) => Object.assign(document.createElement(element), properties);
    const name = cell("label", { className: "name", textContent: key.replace(/^parameters\./, ""), htmlFor: `slider ${key}` });
    const far = value === 0 ? 1 : 2 * value;
    const [min, max] = [Math.min(value === 0 ? -1 : 0, far), Math.max(0, far)];
    const now = this.set.get(key) ?? value;
    const range = cell("input", { type: "range", id: `slider ${key}`, min, max, step: (max - min) / 200 });
    const number = cell("input", { type: "number", step: "any", ariaLabel: `${key}, number` });
    range.value = number.value = now;
    row.classList.toggle("changed", this.set.has(key));
    const change = (given, other) => {
      const wanted = Number(given.value);
      if (given.value === "" || !Number.isFinite(wanted)) return;
      // Rounding of the slider's own steps stays out of the model.
      const rounded = given === range ? Number(wanted.toPrecision(6)) : wanted;
      other.value = rounded;
      if (rounded === value) this.set.delete(key); else this.set.set(key, rounded);
      row.classList.toggle("changed", this.set.has(key));
      this.onchange();
    };
    range.oninput = () => change(range, number);
    number.oninput = () => change(number, range);
    const remove = cell("button", { type: "button", textContent: "\u00d7", ariaLabel: `remove the slider of ${key}` });
    remove.onclick = () => {
      const had = this.set.delete(key);
      this.shown = this.shown.filter(one => one !== key);
      this.draw();
      if (had) this.onchange();
    };
    row.append(name, range, number, cell("span", { textContent: unit }), remove);
    return row;
  },
};
