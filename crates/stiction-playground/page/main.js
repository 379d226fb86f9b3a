// The page: what is typed, moved and chosen becomes requests, and answers become reports.

const reader = new Engine(), runner = new Engine();
const choice = Object.fromEntries(
  ["gallery", "command", "motion", "load", "friction", "until", "live"].map(name => [name, byId(name)]));
const status = byId("status"), bar = byId("progress"), failure = byId("failure"), frame = byId("page");
/** Waiting time after the last change, ms. */
const PAUSE = 250;
let models = [], pending = 0;

const request = command => ({ command, name: editor.name, text: editor.text, changes: sliders.changes, meshes: meshes.files });

/** Messages of an error, for the list below the editor. */
const defects = error =>
  error.diagnostics ?? [{ severity: "error", message: error.message, help: error.help }];

function fill(select, names, first) {
  const before = select.value;
  select.replaceChildren(new Option(first, ""), ...names.map(name => new Option(name, name)));
  if (names.includes(before)) select.value = before;
}

/** Reads the model; true if it has no defect. */
async function read() {
  let answer;
  try {
    answer = await reader.ask(request("read"));
  } catch (error) {
    if (error !== CANCELLED) editor.show([{ severity: "error", message: error.message }]);
    return false;
  }
  if (answer.error) {
    editor.show(defects(answer.error));
    // The report is that of the last text without a defect.
    frame.classList.add("old");
    return false;
  }
  const { values, motions, loads, default_motion, default_load, warnings, title, meshes: named } = answer.ok;
  editor.show(warnings);
  sliders.take(values);
  meshes.tell(named);
  fill(choice.motion, motions, `default${default_motion ? ` (${default_motion})` : ""}`);
  fill(choice.load, loads, `default (${default_load})`);
  document.title = `${title}: Stiction playground`;
  return true;
}

async function run() {
  const command = choice.command.value;
  const friction = choice.friction.value;
  const asked = {
    ...request(command), motion: choice.motion.value, load: choice.load.value,
    friction: friction === "" ? null : friction === "on",
    until: choice.until.value === "" ? null : Number(choice.until.value),
  };
  const begun = performance.now();
  byId("cancel").disabled = false;
  frame.classList.add("old");
  say(`${command} runs`);
  let answer;
  try {
    answer = await runner.ask(asked, (done, of) => {
      bar.hidden = false;
      bar.max = of || 1;
      bar.value = done;
      say(`${command} runs: ${done} of ${of}`);
    });
  } catch (error) {
    if (error === CANCELLED) return;
    answer = { error: { message: error.message } };
  }
  bar.hidden = true;
  byId("cancel").disabled = true;
  if (answer.error) {
    const messages = defects(answer.error);
    failure.textContent = messages.map(one => [one.message, one.help && `help: ${one.help}`].filter(Boolean).join("\n")).join("\n\n");
    failure.hidden = false;
    say(`${command}: no result`);
    return;
  }
  const { page, text, ended } = answer.ok;
  failure.hidden = !ended;
  if (ended) failure.textContent = [ended.message, ended.help && `help: ${ended.help}`].filter(Boolean).join("\n");
  frame.hidden = !page;
  if (page) frame.srcdoc = page;
  frame.classList.remove("old");
  byId("summary").textContent = text;
  say(`${command}: ${((performance.now() - begun) / 1000).toFixed(2)} s`);
}

function say(words) { status.textContent = words; }

/** After a change: reads, then runs if asked to. */
function changed(isTyped) {
  clearTimeout(pending);
  if (isTyped) editor.show([]);
  pending = setTimeout(async () => { if (await read() && choice.live.checked) run(); }, PAUSE);
}

function choose(name) {
  const model = models.find(one => one.name === name);
  if (!model) return;
  sliders.forget();
  choice.motion.value = choice.load.value = "";
  editor.name = name;
  editor.text = model.text;
  changed(false);
}

async function copyLink() {
  const state = {
    name: editor.name, text: editor.text, set: [...sliders.set], shown: sliders.shown,
    ...Object.fromEntries(["command", "motion", "load", "friction", "until"].map(name => [name, choice[name].value])),
  };
  history.replaceState(null, "", `#m=${await packed(state)}`);
  let told = "the address of this page now contains the model";
  try {
    await navigator.clipboard.writeText(location.href);
    told = "link copied; it contains the model";
  } catch { /* The address bar has it. */ }
  byId("copied").textContent = told;
}

async function begin() {
  choice.gallery.onchange = () => choose(choice.gallery.value);
  editor.area.addEventListener("input", () => changed(true));
  sliders.onchange = () => changed(false);
  byId("meshes").onchange = async () => {
    try {
      await meshes.take(byId("meshes").files);
      changed(false);
    } catch (error) {
      byId("meshed").textContent = error.message;
    }
  };
  for (const name of ["command", "motion", "load", "friction", "until"]) {
    choice[name].onchange = () => { byId("span").hidden = choice.command.value !== "forward"; run(); };
  }
  byId("span").hidden = true;
  byId("run").onclick = () => run();
  byId("cancel").onclick = () => {
    runner.cancel();
    bar.hidden = true;
    byId("cancel").disabled = true;
    say("cancelled");
  };
  byId("add").onclick = () => { if (sliders.add(byId("key").value.trim())) byId("key").value = ""; };
  byId("reset").onclick = () => { sliders.set.clear(); sliders.draw(); changed(false); };
  byId("link").onclick = copyLink;
  let answer;
  try {
    answer = await reader.ask({ command: "gallery" });
  } catch (error) {
    say(error.message);
    return;
  }
  models = answer.ok;
  choice.gallery.replaceChildren(...models.map(({ name, title }) => new Option(name, name, name === "3rps", name === "3rps")));
  const state = await linked().catch(() => null);
  if (!state) {
    choose("3rps");
    return;
  }
  choice.gallery.prepend(new Option("from the link", "", true, true));
  editor.name = typeof state.name === "string" ? state.name : "model";
  editor.text = state.text;
  sliders.set = new Map(state.set);
  sliders.shown = state.shown ?? [];
  if (!(await read())) return;
  for (const name of ["command", "motion", "load", "friction", "until"]) choice[name].value = state[name] ?? "";
  run();
}

begin();
