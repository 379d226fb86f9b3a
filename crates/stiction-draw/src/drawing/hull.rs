//! Convex hulls, the outlines of bodies with many joints.

use super::svg::Point;

/// Distance, px, below which two points count as one.
const NEAR: f64 = 0.5;
/// Twice the area of a triangle, px^2, below which its three corners count as collinear.
const FLAT: f64 = 1.0;

/// Computes the corners of the convex hull of `points`, px, in the direction of rotation from the x
/// to the y axis. Returns one corner if all points coincide, and two corners if all points lie on a
/// line.
pub(super) fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup_by(|a, b| (a[0] - b[0]).hypot(a[1] - b[1]) < NEAR);
    if points.len() < 3 {
        return points;
    }
    let turn = |o: Point, a: Point, b: Point| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while let [.., o, a] = chain[..]
                && turn(o, a, point) <= FLAT
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter().copied());
    outline.extend(half(&mut points.iter().rev().copied()));
    outline
}

/// Returns true if `point` lies within the convex hull with the corners `outline`, in the order in
/// which [`hull`] returns them.
pub(super) fn is_within(outline: &[Point], point: Point) -> bool {
    let side = |k: usize| {
        let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
        (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
    };
    outline.len() >= 3 && (0..outline.len()).all(|k| side(k) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_square_with_points_in_it() {
        let square = [[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]];
        let mut points = square.to_vec();
        points.extend([[50.0, 50.0], [50.0, 0.0], [100.0, 100.1], [20.0, 70.0]]);
        let outline = hull(points);
        assert_eq!(outline.len(), 4, "{outline:?}");
        assert!(is_within(&outline, [50.0, 50.0]) && !is_within(&outline, [101.0, 50.0]));
    }

    #[test]
    fn lines_and_points_are_reported() {
        assert_eq!(hull(vec![[1.0, 2.0]; 5]), [[1.0, 2.0]]);
        let line: Vec<Point> = (0..7).map(|k| [f64::from(k) * 10.0, f64::from(k) * 5.0]).collect();
        assert_eq!(hull(line), [[0.0, 0.0], [60.0, 30.0]]);
        assert!(hull(Vec::new()).is_empty() && !is_within(&[], [0.0, 0.0]));
    }
}
