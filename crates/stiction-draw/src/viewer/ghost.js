// The least constrained motion with the actuators held: bodies a little to both sides of their places, dashed.
const ghostFrame = film.ghost ? nearestFrame(film.ghost.time) : -1;
/// Largest displacement of a joint, as a part of the picture's smaller side.
const GHOST_REACH = 0.09;

const ghostMove = (k, frame, point, amount) => {
  const [velocity, angular] = film.ghost.twists[k], origin = placed(frame, k, [0, 0, 0]);
  return plus(point, times3(plus(velocity, cross(angular, minus(point, origin))), amount));
};
const drawGhost = (frame, places) => {
  let fastest = 0;
  scene.bodies.forEach((body, k) => body.joints.forEach(joint => {
    fastest = Math.max(fastest, norm(minus(ghostMove(k, frame, places[joint], 1), places[joint])));
  }));
  if (!(fastest > 0)) return;
  const amount = GHOST_REACH * Math.min(room.width, room.height) / perMetre() / fastest;
  for (const side of [-amount, amount]) scene.bodies.forEach((body, k) => {
    if (!k) return;
    const points = body.joints.map(joint => project(ghostMove(k, frame, places[joint], side)));
    if (points.length < 2) return;
    const outline = hull(points);
    trace(outline, outline.length > 2);
    if (outline.length > 2) fill(ink.link, 0.08);
    stroke(ink.link, 1.6, [6, 4]);
  });
};
