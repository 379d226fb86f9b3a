// Prints the seconds of the fastest of several answers of the module to one request.
import { readFileSync } from "node:fs";

const [module, request, answers, seconds] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(module), { page: { progress() {} } });
const engine = instance.exports, bytes = new TextEncoder().encode(request);

function respond() {
  const at = engine.request(bytes.length);
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
  const begun = performance.now();
  const length = engine.respond();
  const seconds = (performance.now() - begun) / 1000;
  const answer = JSON.parse(new TextDecoder().decode(new Uint8Array(engine.memory.buffer, engine.response(), length)));
  if (answer.error) throw new Error(JSON.stringify(answer.error));
  return seconds;
}

const begun = performance.now();
let fastest = Infinity;
for (let count = 0; count < Number(answers) || performance.now() - begun < 1000 * Number(seconds); ++count)
  fastest = Math.min(fastest, respond());
console.log(fastest);
