//! Convex hull of points, as a closed surface of triangles.
//!
//! Incremental construction with lists of the points outside each face (quickhull). The predicate for the side of a plane
//! is exact, so coplanar, collinear and equal points are no special cases: a point is added only if it is strictly above
//! some face, and then the faces below it have a closed border.

use crate::triangles::Triangle;
use robust::{Coord3D, orient3d};
use std::collections::HashSet;
use stiction_core::spatial::Vec3;

/// Greatest number of faces; the time grows with the square of it, to some seconds.
const MOST: usize = 20_000;

/// Reason why points have no hull with a volume here; the end of a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoHull {
    /// All points lie in a plane.
    Flat,
    /// The hull has more than [`MOST`] faces.
    TooLarge,
}

/// Face of the hull, counterclockwise from outside, and the points strictly above it that belong to its list.
struct Face {
    corners: [usize; 3],
    outside: Vec<usize>,
}

/// Computes the convex hull of points, with finite coordinates; its triangles are counterclockwise from outside.
pub(super) fn convex_hull(points: &[Vec3<f64>]) -> Result<Vec<Triangle>, NoHull> {
    let first = simplex(points).ok_or(NoHull::Flat)?;
    let mut faces: Vec<Face> = Vec::new();
    let [a, b, c, d] = first;
    let all = (0..points.len()).filter(|point| !first.contains(point)).collect();
    add(points, &mut faces, [[a, b, c], [a, d, b], [b, d, c], [c, d, a]], all);
    // Every round takes one point from the lists for good.
    while let Some(at) = faces.iter().rposition(|face| !face.outside.is_empty()) {
        let corners = faces[at].corners.map(|corner| points[corner]);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let height = |point: &usize| (points[*point] - corners[0]).dot(normal);
        let Some(top) =
            faces[at].outside.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b)))
        else {
            break;
        };
        let (seen, kept): (Vec<Face>, Vec<Face>) =
            faces.into_iter().partition(|face| is_above(points, top, face.corners));
        faces = kept;
        let edges = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
        let inner: HashSet<[usize; 2]> = seen.iter().flat_map(|face| edges(face.corners)).collect();
        // In the order of the faces, so that the result is always the same.
        let border = seen.iter().flat_map(|face| edges(face.corners));
        let border = border.filter(|[a, b]| !inner.contains(&[*b, *a]));
        let cone: Vec<[usize; 3]> = border.map(|[a, b]| [a, b, top]).collect();
        let orphans = seen.into_iter().flat_map(|face| face.outside);
        let orphans = orphans.filter(|point| *point != top).collect();
        add(points, &mut faces, cone, orphans);
        if faces.len() > MOST {
            return Err(NoHull::TooLarge);
        }
    }
    Ok(faces.iter().map(|face| face.corners.map(|corner| points[corner])).collect())
}

/// Adds faces, each with those of the points that are strictly above it and above no face before it.
fn add(
    points: &[Vec3<f64>],
    faces: &mut Vec<Face>,
    added: impl IntoIterator<Item = [usize; 3]>,
    mut left: Vec<usize>,
) {
    for corners in added {
        let (outside, rest) = left.into_iter().partition(|point| is_above(points, *point, corners));
        left = rest;
        faces.push(Face { corners, outside });
    }
}

/// True if a point is strictly on the side of a plane from which its corners are counterclockwise.
fn is_above(points: &[Vec3<f64>], point: usize, corners: [usize; 3]) -> bool {
    orientation(points, corners, point) < 0.0
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
    use stiction_core::random::Random;

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

    #[test]
    fn points_in_a_plane_have_no_hull() {
        let flat: Vec<_> =
            (0..9).map(|k| Vec3::new(f64::from(k % 3), f64::from(k / 3), 0.25)).collect();
        for points in [&flat[..], &flat[..3], &flat[..1], &[]] {
            assert_eq!(convex_hull(points), Err(NoHull::Flat));
        }
    }
}
