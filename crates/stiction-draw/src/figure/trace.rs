//! Long series, thinned for drawing.

use super::Line;

/// Long series of points, thinned for drawing to the least and greatest value of each interval.
#[derive(Clone, Debug)]
pub struct Trace {
    stretch: usize,
    /// Number of points in the current interval, with the least and the greatest.
    taken: usize,
    extremes: Option<[(f64, f64); 2]>,
    points: Vec<(f64, f64)>,
}

/// Largest number of points drawn.
const DRAWN: usize = 4000;

impl Trace {
    /// Empty series for `count` points.
    pub fn new(count: usize) -> Self {
        // Each interval keeps two points.
        let stretch = if count <= DRAWN { 1 } else { (2 * count).div_ceil(DRAWN) };
        Self { stretch, taken: 0, extremes: None, points: Vec::new() }
    }

    /// Adds a point.
    pub fn push(&mut self, x: f64, y: f64) {
        let now = (x, y);
        let [lowest, highest] = self.extremes.get_or_insert([now; 2]);
        if y.total_cmp(&lowest.1).is_lt() {
            *lowest = now;
        }
        if y.total_cmp(&highest.1).is_ge() {
            *highest = now;
        }
        self.taken += 1;
        if self.taken == self.stretch {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.taken = 0;
        if let Some([low, high]) = self.extremes.take() {
            let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
            self.points.push(first);
            if second != first {
                self.points.push(second);
            }
        }
    }

    /// Curve of the series with its name in the legend, the index of its colour, and dashed or
    /// solid.
    pub fn line(self, label: &str, colour: usize, dashed: bool) -> Line {
        Line { label: label.to_owned(), points: self.into_points(), colour, dashed }
    }

    /// Points to draw.
    fn into_points(mut self) -> Vec<(f64, f64)> {
        self.flush();
        self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_extremes() {
        let mut trace = Trace::new(1_000_000);
        for k in 0..1_000_000 {
            let spike = if k == 777_777 { 5.0 } else { 0.0 };
            trace.push(k as f64, (k as f64 * 1e-4).sin() + spike);
        }
        let points = trace.into_points();
        assert!(points.len() <= DRAWN + 2);
        assert!(points.iter().any(|p| p.0 == 777_777.0 && p.1 > 4.0));
        assert!(points.is_sorted_by(|a, b| a.0 <= b.0));
    }
}
