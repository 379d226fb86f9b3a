"use strict";
// Runs the engine beside the page, which stays responsive and can end a computation with its worker.
const encoder = new TextEncoder(), decoder = new TextDecoder();
const INTERVAL = 50; // least time between two reports of progress, ms
let started, engine, asked, reported = 0;

function progress(done, of) {
  const now = performance.now();
  if (now - reported < INTERVAL) return;
  reported = now;
  postMessage({ id: asked, done: done >>> 0, of: of >>> 0 });
}

function respond(request) {
  const bytes = encoder.encode(request);
  const at = engine.request(bytes.length);
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
  const length = engine.respond();
  // The memory may have grown, and its old buffer with the request is then gone.
  return decoder.decode(new Uint8Array(engine.memory.buffer, engine.response(), length));
}

onmessage = async ({ data }) => {
  if (data.module) {
    started = WebAssembly.instantiate(data.module, { page: { progress } });
    return;
  }
  try {
    engine = (await started).instance.exports;
    asked = data.id;
    postMessage({ id: data.id, answer: respond(data.request) });
  } catch (error) {
    postMessage({ id: data.id, failure: String(error) });
  }
};
