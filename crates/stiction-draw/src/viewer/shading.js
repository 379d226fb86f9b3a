// The shaded view: meshes drawn below the picture by a script of its own, on pages that have one.
const shading = { draw: null, image: null, bodies: new Set() };
const isShaded = body => state.shaded && shading.bodies.has(body);
