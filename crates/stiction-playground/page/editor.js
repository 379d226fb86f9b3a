// The editor: line numbers, underlined defects, and their messages.

const editor = {
  name: "model", area: byId("text"), marks: byId("marks"), numbers: byId("numbers"), list: byId("messages"),

  /** Name of the text in messages. */
  get file() { return `${this.name}.toml`; },
  get text() { return this.area.value; },
  set text(value) { this.area.value = value; this.show([]); },

  /** Underlines the places of diagnostics and lists their messages. */
  show(diagnostics) {
    const lines = this.text.split("\n");
    this.numbers.textContent = lines.map((_, k) => k + 1).join("\n");
    const starts = [0];
    for (const line of lines) starts.push(starts.at(-1) + line.length + 1);
    // Columns count characters, offsets of the text units of UTF-16.
    const offset = (line, column) =>
      (starts[line - 1] ?? this.text.length) + [...(lines[line - 1] ?? "")].slice(0, column - 1).join("").length;
    const places = diagnostics
      .filter(one => one.line && one.file === this.file)
      .map(one => {
        const from = offset(one.line, one.column);
        return { from, to: Math.max(offset(one.end_line, one.end_column), from + 1), kind: one.severity };
      })
      .sort((a, b) => a.from - b.from);
    this.marks.replaceChildren();
    let at = 0;
    for (const { from, to, kind } of places) {
      if (from < at) continue;
      const mark = document.createElement("mark");
      mark.className = kind;
      mark.textContent = this.text.slice(from, to) === "\n" ? " \n" : this.text.slice(from, to);
      this.marks.append(this.text.slice(at, from), mark);
      at = to;
    }
    this.marks.append(this.text.slice(at) + "\n");
    this.list.replaceChildren(...diagnostics.map(one => this.message(one, offset)));
    this.follow();
  },

  message(one, offset) {
    const item = document.createElement("li");
    item.className = one.severity;
    const words = [one.message, one.label, one.help && `help: ${one.help}`].filter(Boolean).join("; ");
    if (one.line && one.file === this.file) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = `line ${one.line}`;
      button.onclick = () => {
        this.area.focus();
        this.area.setSelectionRange(offset(one.line, one.column), offset(one.end_line, one.end_column));
      };
      item.append(button, `: ${words}`);
    } else {
      item.textContent = one.file ? `${one.file}: ${words}` : words;
    }
    return item;
  },

  /** Numbers and marks scroll with the text. */
  follow() {
    this.marks.scrollTop = this.numbers.scrollTop = this.area.scrollTop;
    this.marks.scrollLeft = this.area.scrollLeft;
  },
};
editor.area.addEventListener("scroll", () => editor.follow());
// Tab moves on, as everywhere on the page; typing is never trapped.
