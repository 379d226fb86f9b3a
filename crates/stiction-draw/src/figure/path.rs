//! Path of a point in space, thinned for drawing.

/// Path of a point in space, thinned for drawing: of each group of successive points, only those with the least or the
/// greatest value of a coordinate are kept.
#[derive(Clone, Debug)]
pub struct PathTrace {
    stretch: usize,
    group: Vec<[f64; 3]>,
    points: Vec<[f64; 3]>,
}

/// Largest number of groups of successive points.
const GROUPS: usize = 500;

impl PathTrace {
    /// Creates an empty path. The expected number of points, `count`, determines the size of the
    /// groups.
    pub fn new(count: usize) -> Self {
        // Each group keeps up to six points.
        let stretch = if count <= 6 * GROUPS { 1 } else { count.div_ceil(GROUPS) };
        Self { stretch, group: Vec::new(), points: Vec::new() }
    }

    /// Adds a point, m; a coordinate that is not finite interrupts the path.
    pub fn push(&mut self, point: [f64; 3]) {
        self.group.push(point);
        if self.group.len() >= self.stretch {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let mut keep = vec![false; self.group.len()];
        for axis in 0..3 {
            let order =
                |a: &usize, b: &usize| self.group[*a][axis].total_cmp(&self.group[*b][axis]);
            let ends = [(0..keep.len()).min_by(order), (0..keep.len()).max_by(order)];
            ends.into_iter().flatten().for_each(|k| keep[k] = true);
        }
        let kept = self.group.drain(..).zip(keep).filter(|(_, keep)| *keep);
        self.points.extend(kept.map(|(point, _)| point));
    }

    /// Returns the points to draw.
    pub fn into_points(mut self) -> Vec<[f64; 3]> {
        self.flush();
        self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_extremes_of_a_path() {
        let mut path = PathTrace::new(100_000);
        for k in 0..100_000 {
            let spike = if k == 77_777 { 5.0 } else { 0.0 };
            path.push([f64::from(k), 0.0, (f64::from(k) * 1e-3).sin() + spike]);
        }
        let points = path.into_points();
        assert!(points.len() <= 6 * GROUPS, "{}", points.len());
        assert!(points.iter().any(|point| point[0] == 77_777.0 && point[2] > 4.0));
        assert_eq!((points[0][0], points[points.len() - 1][0]), (0.0, 99_999.0));
        assert!(points.is_sorted_by(|a, b| a[0] < b[0]));
    }

    #[test]
    fn short_paths_are_complete() {
        let mut path = PathTrace::new(3);
        let points = [[0.0; 3], [f64::NAN; 3], [1.0, 0.0, 0.0]];
        points.iter().for_each(|point| path.push(*point));
        let found = path.into_points();
        assert!(found.len() == 3 && found[1][0].is_nan() && found[2] == points[2]);
    }
}
