// The shaded view of a report: meshes of bodies, drawn by three.js below the picture of joints and arrows.
import {
  Box3, DirectionalLight, DoubleSide, Group, HemisphereLight, Mesh, MeshLambertMaterial, OrthographicCamera, Scene,
  Vector3, WebGLRenderer,
} from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";

const unpacked = async data => {
  const bytes = Uint8Array.from(atob(data), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
};
// Nothing is loaded: colours are those of the legs, and data are in the file, those of a text in base 64.
const selfContained = parser => {
  const inFile = parser.loadBuffer.bind(parser);
  parser.loadBuffer = async index => {
    const [head, data] = (parser.json.buffers[index].uri ?? "").split(",", 2);
    if (!head) return inFile(index);
    if (!/^data:[^,]*;base64$/.test(head)) throw new Error("its data are not in base 64");
    return Uint8Array.from(atob(data), letter => letter.charCodeAt(0)).buffer;
  };
  return { name: "self-contained", loadTexture: () => Promise.resolve(null) };
};
const parsed = async ({ format, data }) => {
  const buffer = await unpacked(data);
  if (format === "stl") return new Mesh(new STLLoader().parse(buffer));
  if (format === "obj") return new OBJLoader().parse(new TextDecoder().decode(buffer));
  return (await new GLTFLoader().register(selfContained).parseAsync(buffer, "")).scene;
};

const begin = async view => {
  let renderer;
  try {
    renderer = new WebGLRenderer({ antialias: true, alpha: true });
  } catch {
    view.fail("This browser cannot draw the meshes: it has no WebGL.");
    return;
  }
  const scene = new Scene(), camera = new OrthographicCamera(), light = new DirectionalLight(0xffffff, 2.2);
  scene.add(new HemisphereLight(0xffffff, 0x8a8f98, 1.6), light, light.target);
  const files = await Promise.all(view.film.files.map(async file => {
    try {
      const object = await parsed(file);
      object.traverse(part => {
        if (part.isLine || part.isPoints || part.isLight) part.visible = false;
        if (!part.isMesh) return;
        if (!part.geometry.getAttribute("normal")) part.geometry.computeVertexNormals();
        // A file may state other bounds than those of its points.
        part.geometry.computeBoundingBox();
        part.geometry.computeBoundingSphere();
      });
      const box = new Box3().setFromObject(object), numbers = [...box.min.toArray(), ...box.max.toArray()];
      if (!numbers.every(Number.isFinite)) throw new Error("it has no extent");
      return { object, box };
    } catch (error) {
      view.fail(`The mesh ${file.name} cannot be shown: ${error.message}.`);
      return null;
    }
  }));
  const bodies = new Map(), corners = [];
  for (const { body, file, scale, position, quaternion: [w, x, y, z] } of view.film.meshes) {
    if (!files[file]) continue;
    if (!bodies.has(body)) {
      const material = new MeshLambertMaterial({ side: DoubleSide }), group = new Group();
      bodies.set(body, { group, material, colour: "" });
      scene.add(group);
    }
    const { group, material } = bodies.get(body), placed = new Group(), object = files[file].object.clone();
    object.traverse(part => { if (part.isMesh) part.material = material; });
    placed.position.fromArray(position); placed.quaternion.set(x, y, z, w); placed.scale.fromArray(scale);
    placed.add(object); group.add(placed);
    placed.updateMatrix();
    const { min, max } = files[file].box;
    for (let k = 0; k < 8; k++) {
      const corner = new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z);
      corners.push([body, corner.applyMatrix4(placed.matrix).toArray()]);
    }
  }
  if (!bodies.size) return;

  const canvas = renderer.domElement;
  canvas.className = "shaded";
  canvas.setAttribute("aria-hidden", "true");
  const draw = isOn => {
    canvas.style.display = isOn ? "" : "none";
    if (!isOn) return;
    const { width, height } = view.room, scale = view.camera.scale * view.camera.zoom;
    renderer.setPixelRatio(Math.min(3, window.devicePixelRatio || 1));
    renderer.setSize(width, height);
    // The same parallel projection as that of the picture above; in its depth the whole robot has room.
    const range = 8 * Math.max(width, height) / view.camera.scale;
    Object.assign(camera, {
      left: -0.5 * width / scale, right: 0.5 * width / scale,
      top: (0.5 * height - 10) / scale, bottom: -(0.5 * height + 10) / scale, near: 0, far: range,
    });
    const centre = new Vector3().fromArray(view.camera.centre), toward = new Vector3().fromArray(view.camera.toward);
    camera.up.fromArray(view.camera.up);
    camera.position.copy(centre).addScaledVector(toward, 0.5 * range);
    camera.lookAt(centre);
    camera.updateProjectionMatrix();
    light.target.position.copy(centre);
    light.position.copy(centre).add(toward).addScaledVector(camera.up, 0.7)
      .addScaledVector(new Vector3().fromArray(view.camera.right), 0.4);
    for (const [body, own] of bodies) {
      const { position, quaternion: [w, x, y, z] } = view.poseOf(body), colour = view.colourOf(body);
      own.group.position.fromArray(position); own.group.quaternion.set(x, y, z, w);
      if (colour !== own.colour) { own.colour = colour; own.material.color.set(colour); }
    }
    renderer.render(scene, camera);
  };
  view.begin({ canvas, bodies: [...bodies.keys()], corners, draw, image: () => canvas.toDataURL("image/png") });
};

const view = document.getElementById("robot")?.shading;
if (view) begin(view);
