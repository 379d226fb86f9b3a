// Mesh files that the reader picks, by the names in the model; they stay in the page.

const meshes = {
  /** Pairs of a name and a content in base 64. */
  files: [],

  /** Reads picked files. */
  async take(list) {
    const size = [...list].reduce((sum, file) => sum + file.size, 0);
    if (size > MOST_MESHES) throw new Error(`the files have ${Math.ceil(size / 1e6)} MB; at most ${MOST_MESHES / 1e6} MB can be used`);
    this.files = await Promise.all(Array.from(list, async file => [file.name, await encoded(file)]));
  },

  /** Says which meshes of the model are given; `named` are pairs of a path and true if the mesh is shown. */
  tell(named) {
    const last = path => path.split(/[\\/]/).at(-1), paths = new Set(named.map(([path]) => last(path)));
    const unused = this.files.map(([name]) => name).filter(name => !paths.has(name));
    const parts = [];
    if (named.length) parts.push(`${named.filter(([, isShown]) => isShown).length} of ${named.length} meshes of the model are given`);
    if (unused.length) parts.push(`the model does not name ${unused.join(", ")}`);
    byId("meshed").textContent = parts.join("; ");
  },
};
/** Largest size of all picked files, bytes; a report takes less. */
const MOST_MESHES = 24e6;

/** Content of a file in base 64. */
function encoded(file) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
    reader.onerror = () => reject(new Error(`${file.name} cannot be read`));
    reader.readAsDataURL(file);
  });
}
