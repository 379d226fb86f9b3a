//! Convex hull of points, as a closed surface of triangles.
//!
//! Randomised incremental construction with lists of the points outside each face (Clarkson and Shor): the points are added
//! in a random order (always the same one). The expected time is of order n log n for n points if each point of the hull has
//! few neighbours. A point with k neighbours, such as the tip of a cone with k points along its rim, may add a time of order
//! k n, because its faces are searched one after the other.
//!
//! The predicate for the side of a plane is exact, so coplanar, collinear and equal points are no special cases: a point is
//! added only if it is strictly above some face. The faces below it are then connected, their border is a single closed
//! line, and points of their lists that are above no new face are inside.

use crate::triangles::Triangle;
use robust::{Coord3D, orient3d};
use std::collections::HashSet;
use stiction_core::random::Random;
use stiction_core::spatial::Vec3;

/// Error of points without a hull: all of them lie in a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Flat;

/// Face of the hull, counterclockwise from outside.
struct Face {
    corners: [usize; 3],
    /// Neighbours across the edges from each corner to the next.
    neighbours: [usize; 3],
    /// Indices of points strictly outside this face that do not yet lie in the hull. Each such point is in the list of
    /// one face only.
    outside: Vec<usize>,
}

/// Computes the convex hull of points, with finite coordinates; its triangles are counterclockwise from outside.
pub(super) fn convex_hull(points: &[Vec3<f64>]) -> Result<Vec<Triangle>, Flat> {
    let points = shuffled(distinct(points));
    let first = simplex(&points).ok_or(Flat)?;
    let mut hull = Hull::new(&points, first);
    hull.add_all();
    hull.faces.retain(|face| face.corners != GONE);
    Ok(hull.faces.iter().map(|face| face.corners.map(|corner| points[corner])).collect())
}

/// Corners of a face that is no longer part of the hull.
const GONE: [usize; 3] = [usize::MAX; 3];

/// Hull of the points added so far.
struct Hull<'a> {
    points: &'a [Vec3<f64>],
    faces: Vec<Face>,
    /// Indices of faces that are gone, to be used again.
    free: Vec<usize>,
    /// For each point that is not yet added, the face in whose list it is; `None` for points of the hull and inside it.
    face_below: Vec<Option<usize>>,
    /// Number of tests if a point is above a face, the measure of the work.
    #[cfg(test)]
    comparisons: usize,
    /// For corners of the border of the faces below a new point: the new face at the edge that begins there.
    face_after: Vec<usize>,
}

/// Edge of the border of the faces below a new point.
struct BorderEdge {
    from: usize,
    to: usize,
    /// The face on the other side of the edge, which remains.
    beyond: usize,
}

impl<'a> Hull<'a> {
    /// Creates the hull of four points; the first three are counterclockwise seen from the side away from the fourth.
    fn new(points: &'a [Vec3<f64>], [a, b, c, d]: [usize; 4]) -> Self {
        let face = |corners, neighbours| Face { corners, neighbours, outside: Vec::new() };
        let faces = vec![
            face([a, b, c], [1, 2, 3]),
            face([a, d, b], [3, 2, 0]),
            face([b, d, c], [1, 3, 0]),
            face([c, d, a], [2, 1, 0]),
        ];
        let count = points.len();
        let mut hull = Self {
            points,
            faces,
            free: Vec::new(),
            face_below: vec![None; count],
            #[cfg(test)]
            comparisons: 0,
            face_after: vec![0; count],
        };
        hull.assign((0..count).filter(|point| ![a, b, c, d].contains(point)), &[0, 1, 2, 3]);
        hull
    }

    /// Adds all points that are outside.
    fn add_all(&mut self) {
        for point in 0..self.points.len() {
            if let Some(face) = self.face_below[point] {
                self.add(point, face);
            }
        }
    }

    /// True if a point is strictly on the outer side of a face.
    fn is_above(&mut self, point: usize, face: usize) -> bool {
        #[cfg(test)]
        {
            self.comparisons += 1;
        }
        orientation(self.points, self.faces[face].corners, point) < 0.0
    }

    /// Puts each point into the list of the first of these faces that it is strictly above; the others are inside.
    fn assign(&mut self, points: impl IntoIterator<Item = usize>, faces: &[usize]) {
        for point in points {
            let below = faces.iter().copied().find(|face| self.is_above(point, *face));
            self.face_below[point] = below;
            if let Some(face) = below {
                self.faces[face].outside.push(point);
            }
        }
    }

    /// Adds a point that is strictly above the face `first`.
    fn add(&mut self, point: usize, first: usize) {
        let (below, border) = self.faces_below(point, first);
        let mut orphans = Vec::new();
        for &face in &below {
            self.faces[face].corners = GONE;
            orphans.append(&mut self.faces[face].outside);
        }
        self.free.extend(below);
        let cone: Vec<usize> = border.iter().map(|edge| self.add_face(edge, point)).collect();
        for (edge, &face) in border.iter().zip(&cone) {
            let next = self.face_after[edge.to];
            self.faces[face].neighbours[1] = next;
            self.faces[next].neighbours[2] = face;
        }
        self.face_below[point] = None;
        self.assign(orphans.into_iter().filter(|orphan| *orphan != point), &cone);
    }

    /// Finds the faces strictly below a point, starting with `first`, and their border.
    fn faces_below(&mut self, point: usize, first: usize) -> (Vec<usize>, Vec<BorderEdge>) {
        let (mut below, mut border) = (vec![first], Vec::new());
        let mut known = HashSet::from([first]);
        let mut next = 0;
        while let Some(&face) = below.get(next) {
            let Face { corners, neighbours, .. } = self.faces[face];
            for k in 0..3 {
                let beyond = neighbours[k];
                if known.contains(&beyond) {
                    continue;
                }
                if self.is_above(point, beyond) {
                    known.insert(beyond);
                    below.push(beyond);
                } else {
                    border.push(BorderEdge { from: corners[k], to: corners[(k + 1) % 3], beyond });
                }
            }
            next += 1;
        }
        (below, border)
    }

    /// Adds the face from an edge of the border to a point, connected to the face beyond the edge. Returns its index.
    fn add_face(&mut self, edge: &BorderEdge, point: usize) -> usize {
        let corners = [edge.from, edge.to, point];
        let face = Face { corners, neighbours: [edge.beyond; 3], outside: Vec::new() };
        let index = match self.free.pop() {
            Some(index) => {
                self.faces[index] = face;
                index
            }
            None => {
                self.faces.push(face);
                self.faces.len() - 1
            }
        };
        let beyond = &mut self.faces[edge.beyond];
        for k in 0..3 {
            // The neighbour has the edge in the opposite direction.
            if beyond.corners[k] == edge.to {
                beyond.neighbours[k] = index;
            }
        }
        self.face_after[edge.from] = index;
        index
    }
}

/// Points without repetitions; negative zeros become positive.
fn distinct(points: &[Vec3<f64>]) -> Vec<Vec3<f64>> {
    let mut known = HashSet::new();
    let point = |point: &Vec3<f64>| Vec3::from(point.to_array().map(|x| x + 0.0));
    let mut distinct: Vec<_> = points.iter().map(point).collect();
    distinct.retain(|point| known.insert(point.to_array().map(f64::to_bits)));
    distinct
}

/// Points in a random order, the same in every run.
fn shuffled(mut points: Vec<Vec3<f64>>) -> Vec<Vec3<f64>> {
    let mut random = Random::new(1);
    for last in (1..points.len()).rev() {
        let part = 0.5 * (random.number() + 1.0);
        points.swap(last, ((part * (last + 1) as f64) as usize).min(last));
    }
    points
}

fn orientation(points: &[Vec3<f64>], [a, b, c]: [usize; 3], d: usize) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|index| {
        let [x, y, z] = points[index].to_array();
        Coord3D { x, y, z }
    });
    orient3d(a, b, c, d)
}

/// Four points that are not in a plane; the first three are counterclockwise seen from the side away from the fourth.
fn simplex(points: &[Vec3<f64>]) -> Option<[usize; 4]> {
    let farthest = |from: &dyn Fn(Vec3<f64>) -> f64| {
        (0..points.len()).max_by(|a, b| from(points[*a]).total_cmp(&from(points[*b])))
    };
    let a = farthest(&|point| -point.x)?;
    let b = farthest(&|point| (point - points[a]).norm())?;
    let line = points[b] - points[a];
    let c = farthest(&|point| (point - points[a]).cross(line).norm())?;
    let normal = line.cross(points[c] - points[a]);
    let d = farthest(&|point| (point - points[a]).dot(normal).abs())?;
    // Nearly flat points: the farthest by rounded distances may be exactly in the plane, another one not.
    let is_off = |d: &usize| orientation(points, [a, b, c], *d) != 0.0;
    let d = Some(d).filter(is_off).or_else(|| (0..points.len()).find(is_off))?;
    let is_outwards = orientation(points, [a, b, c], d) > 0.0;
    Some(if is_outwards { [a, b, c, d] } else { [a, c, b, d] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// Checks that triangles are a closed convex surface with all points on it or inside, and returns its volume.
    fn volume(points: &[Vec3<f64>]) -> f64 {
        let hull = convex_hull(points).unwrap();
        let mut edges: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
        let bits = |point: Vec3<f64>| point.to_array().map(f64::to_bits);
        let mut volume = 0.0;
        for [a, b, c] in &hull {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([bits(*from), bits(*to)]).or_default() += 1;
                *edges.entry([bits(*to), bits(*from)]).or_default() -= 1;
            }
            for point in points {
                let all = [*a, *b, *c, *point];
                assert!(orientation(&all, [0, 1, 2], 3) >= 0.0, "{point:?} is outside");
            }
            volume += (*a - points[0]).dot((*b - points[0]).cross(*c - points[0])) / 6.0;
        }
        assert!(edges.values().all(|count| *count == 0), "the surface is not closed");
        volume
    }

    /// Many points of a lattice are in common planes and on common lines; some are given twice.
    #[test]
    fn a_lattice_has_the_hull_of_its_corners() {
        let mut points = Vec::new();
        for (x, y, z) in
            (0..5).flat_map(|x| (0..4).flat_map(move |y| (0..4).map(move |z| (x, y, z))))
        {
            points.push(Vec3::new(0.1 * f64::from(x), 0.3 * f64::from(y), 0.7 * f64::from(z)));
        }
        points.extend_from_within(10..30);
        let expected = 0.4 * 0.9 * 2.1;
        assert!((volume(&points) - expected).abs() < 1e-14, "{}", volume(&points));
    }

    #[test]
    fn random_points_are_inside() {
        let mut random = Random::new(7);
        for count in [4, 5, 8, 30, 300] {
            // In a cube, on a sphere, and rounded to a coarse lattice.
            let cube: Vec<_> =
                (0..count).map(|_| Vec3::from(std::array::from_fn(|_| random.number()))).collect();
            let sphere: Vec<_> = cube.iter().filter_map(|point| point.direction()).collect();
            let coarse =
                |point: &Vec3<f64>| Vec3::from(point.to_array().map(|x| (3.0 * x).round()));
            let lattice: Vec<_> = cube.iter().map(coarse).collect();
            for points in [cube, sphere] {
                assert!(volume(&points) > 0.0);
            }
            if count > 8 {
                assert!(volume(&lattice) > 0.0);
            }
        }
        let ball: Vec<_> = (0..2000)
            .filter_map(|_| Vec3::from(std::array::from_fn(|_| random.number())).direction())
            .collect();
        let ideal = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((0.99 * ideal..ideal).contains(&volume(&ball)), "{}", volume(&ball));
    }

    /// Adding points in order of a coordinate, and points on a line that is bent ever less, makes an algorithm that
    /// depends on the order or takes the farthest points quadratic. Counts comparisons instead of seconds.
    #[test]
    fn the_work_grows_little_faster_than_the_number_of_points() {
        let mut random = Random::new(3);
        let mut kinds: [Vec<Vec3<f64>>; 4] = Default::default();
        for k in 0..16_000 {
            let t = f64::from(k) / 16_000.0;
            kinds[0].extend(random.vector().direction());
            kinds[1].push(random.vector());
            kinds[2].push(Vec3::new(t, t * t, t * t * t));
            kinds[3].push(Vec3::new(
                f64::from(k % 40),
                f64::from(k / 40 % 40),
                f64::from(k / 1600),
            ));
        }
        for points in kinds {
            let comparisons = |count: usize| {
                let points = shuffled(distinct(&points[..count]));
                let mut hull = Hull::new(&points, simplex(&points).unwrap());
                hull.add_all();
                hull.comparisons as f64
            };
            let (few, many) = (comparisons(4_000), comparisons(16_000));
            // Four times as many points; n² would be 16 times the work, n log n 4.7 times.
            assert!(many < 6.5 * few, "{few} {many}");
            assert!(many < 150.0 * 16_000.0, "{many}");
        }
    }

    #[test]
    fn points_in_a_plane_have_no_hull() {
        let flat: Vec<_> =
            (0..9).map(|k| Vec3::new(f64::from(k % 3), f64::from(k / 3), 0.25)).collect();
        for points in [&flat[..], &flat[..3], &flat[..1], &[]] {
            assert_eq!(convex_hull(points), Err(Flat));
        }
    }
}
