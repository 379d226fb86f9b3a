// A link that carries the whole state of the page, compressed, behind the number sign: no server sees it.

async function through(stream, bytes) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

async function packed(state) {
  const bytes = await through(new CompressionStream("deflate-raw"), new TextEncoder().encode(JSON.stringify(state)));
  let letters = "";
  for (const byte of bytes) letters += String.fromCharCode(byte);
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** The state in the page's address, `null` if there is none. */
async function linked() {
  const found = /^#m=([\w-]+)$/.exec(location.hash);
  if (!found) return null;
  const letters = atob(found[1].replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = await through(new DecompressionStream("deflate-raw"), Uint8Array.from(letters, l => l.charCodeAt(0)));
  const state = JSON.parse(new TextDecoder().decode(bytes));
  return typeof state.text === "string" ? state : null;
}
