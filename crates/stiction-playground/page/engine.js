// The engine in workers: a request is an object, its answer a promise.

const byId = name => document.getElementById(name);

/** Bytes of the compiled module, from the page or from the file beside it. */
async function moduleBytes() {
  const packed = byId("module").textContent.trim();
  if (packed) {
    const bytes = Uint8Array.from(atob(packed), letter => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }
  const file = await fetch("stiction.wasm");
  if (!file.ok) throw new Error(`the file stiction.wasm in the folder of this page cannot be read (${file.status})`);
  return new Uint8Array(await file.arrayBuffer());
}

/** Reason why a request has no answer: it was cancelled. */
const CANCELLED = Symbol("cancelled");

class Engine {
  static #source = URL.createObjectURL(new Blob([byId("worker").textContent], { type: "text/javascript" }));
  static #module = moduleBytes();
  #worker = null;
  #waiting = null;
  #last = 0;

  get busy() { return this.#waiting !== null; }

  /** Sends a request; one that waits is cancelled. `onProgress` receives the part done, and the whole. */
  async ask(request, onProgress = () => {}) {
    this.cancel();
    const id = ++this.#last;
    const answer = new Promise((resolve, reject) => { this.#waiting = { id, resolve, reject, onProgress }; });
    Engine.#module.then(module => {
      if (this.#waiting?.id !== id) return;
      if (!this.#worker) this.#start(module);
      this.#worker.postMessage({ id, request: JSON.stringify(request) });
    }, error => this.#settle(id, "reject", error));
    return answer;
  }

  /** Ends the computation that waits, if there is one. */
  cancel() {
    if (!this.#waiting) return;
    const { id } = this.#waiting;
    this.#worker?.terminate();
    this.#worker = null;
    this.#settle(id, "reject", CANCELLED);
  }

  #start(module) {
    this.#worker = new Worker(Engine.#source);
    this.#worker.postMessage({ module });
    this.#worker.onerror = event => this.#stopped(this.#waiting?.id, event.message);
    this.#worker.onmessage = ({ data }) => {
      if (this.#waiting?.id !== data.id) return;
      if (data.failure !== undefined) this.#stopped(data.id, data.failure);
      else if (data.answer !== undefined) this.#settle(data.id, "resolve", JSON.parse(data.answer));
      else this.#waiting.onProgress(data.done, data.of);
    };
  }

  /** After a trap the memory of the engine is not to be trusted. */
  #stopped(id, why) {
    this.#worker?.terminate();
    this.#worker = null;
    this.#settle(id, "reject", new Error(`the engine stopped unexpectedly (${why}); please report the model`));
  }

  #settle(id, how, value) {
    if (this.#waiting?.id !== id) return;
    const waiting = this.#waiting;
    this.#waiting = null;
    waiting[how](value);
  }
}
