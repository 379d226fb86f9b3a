//! Long series of points, thinned for drawing.

use super::{Band, Line};

/// Long series of points, thinned for drawing: of each group of successive points, only the least
/// and the greatest value are kept.
#[derive(Clone, Debug)]
pub struct Trace {
    stretch: usize,
    /// Number of points in the current group; `extremes` are the least and the greatest point of
    /// this group.
    taken: usize,
    extremes: Option<[(f64, f64); 2]>,
    points: Vec<(f64, f64)>,
}

/// Largest number of points that are drawn.
const DRAWN: usize = 2800;

impl Trace {
    /// Creates an empty series. The expected number of points, `count`, determines the size of the
    /// groups.
    pub fn new(count: usize) -> Self {
        // Each group keeps two points.
        let stretch = if count <= DRAWN { 1 } else { (2 * count).div_ceil(DRAWN) };
        Self { stretch, taken: 0, extremes: None, points: Vec::new() }
    }

    /// Adds a point to the series.
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

    /// Interrupts the curve after the last point.
    pub fn interrupt(&mut self) {
        self.flush();
        if self.points.last().is_some_and(|point| point.1.is_finite()) {
            self.points.push((f64::NAN, f64::NAN));
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

    /// Converts the series to a curve, dashed or solid. `label` is its name in the legend, `colour`
    /// its colour index.
    pub fn line(self, label: &str, colour: usize, dashed: bool) -> Line {
        Line { label: label.to_owned(), points: self.into_points(), colour, dashed }
    }

    /// Returns the points to draw.
    fn into_points(mut self) -> Vec<(f64, f64)> {
        self.flush();
        self.points
    }
}

/// Curve of a quantity with a smooth part and a friction part. The friction part jumps where
/// sliding reverses; at rest, it is not a single value but an interval. Samples alone would show
/// jumps as slopes and rest as spikes.
///
/// Both sides of a jump are extrapolated linearly from the samples before and after the jump, so
/// that a reversal at another friction interface causes no step in a quantity that is smooth there.
#[derive(Clone, Debug)]
pub struct JumpTrace {
    trace: Trace,
    /// The last four samples: sample `k` has the index `k` modulo four.
    recent: [Sample; 4],
    /// Number of samples. All but the newest are drawn; it is drawn when the next one is known.
    count: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    time: f64,
    smooth: f64,
    part: f64,
    rests: bool,
    /// Instant, s, of a reversal of sliding since the previous sample.
    reversal: Option<f64>,
}

impl Sample {
    /// Returns the time derivative of the friction part since the sample `before`; zero if a jump
    /// or rest makes it unknown.
    fn rate_since(&self, before: &Self) -> f64 {
        let rate = (self.part - before.part) / (self.time - before.time);
        let is_smooth = self.reversal.is_none() && !self.rests && !before.rests;
        if is_smooth && rate.is_finite() { rate } else { 0.0 }
    }
}

impl JumpTrace {
    /// Creates an empty curve. The expected number of samples, `count`, determines the thinning.
    pub fn new(count: usize) -> Self {
        Self { trace: Trace::new(count), recent: [Sample::default(); 4], count: 0 }
    }

    /// Adds a sample at a time (s): the smooth part, the friction part, true if the friction part
    /// is an interval because the mechanism rests, and the instant of a reversal since the last
    /// sample, if any.
    pub fn push(&mut self, time: f64, smooth: f64, part: f64, rests: bool, reversal: Option<f64>) {
        self.recent[self.count % 4] = Sample { time, smooth, part, rests, reversal };
        self.count += 1;
        if self.count > 1 {
            self.draw(2);
        }
    }

    /// Returns the last sample (`back` is 1) or an earlier one; `None` before the first one.
    fn sample(&self, back: usize) -> Option<Sample> {
        Some(self.recent[self.count.checked_sub(back)? % 4])
    }

    /// Draws a sample, of which `back` is the place from the end as in [`Self::sample`].
    fn draw(&mut self, back: usize) {
        let Some(now) = self.sample(back) else { return };
        let Sample { time, smooth, part, rests, reversal } = now;
        let Some(last) = self.sample(back + 1) else {
            if !rests {
                self.trace.push(time, smooth + part);
            }
            return;
        };
        match (last.rests, rests) {
            // At the first sample at rest, the curve ends with the friction of the previous sample.
            // After the rest, it continues with the friction of the first moving sample.
            (false, true) => self.trace.push(time, smooth + last.part),
            (true, true) => self.trace.interrupt(),
            (true, false) => {
                self.trace.push(last.time, last.smooth + part);
                self.trace.push(time, smooth + part);
            }
            (false, false) => {
                if let Some(at) = reversal {
                    let passed = at - last.time;
                    let between =
                        last.smooth + (smooth - last.smooth) * passed / (time - last.time);
                    let before = self.sample(back + 2);
                    let next = if back > 1 { self.sample(back - 1) } else { None };
                    let rate_before = before.map_or(0.0, |before| last.rate_since(&before));
                    let rate_after = next.map_or(0.0, |next| next.rate_since(&now));
                    self.trace.push(at, between + last.part + rate_before * passed);
                    self.trace.push(at, between + part - rate_after * (time - at));
                }
                self.trace.push(time, smooth + part);
            }
        }
    }

    /// Converts the samples to a curve; see [`Trace::line`].
    pub fn line(mut self, label: &str, colour: usize, dashed: bool) -> Line {
        self.draw(1);
        self.trace.line(label, colour, dashed)
    }
}

/// Returns the instant at which a velocity reverses between two samples, by linear interpolation.
/// Each sample is a time and a velocity. Returns `None` if the velocity does not change its sign.
pub fn reversal((t0, v0): (f64, f64), (t1, v1): (f64, f64)) -> Option<f64> {
    (v0 * v1 < 0.0).then(|| t0 + (t1 - t0) * v0 / (v0 - v1))
}

/// Interval of a quantity as a function of time, thinned for drawing: of each group of successive
/// samples, only the widest interval is kept.
#[derive(Clone, Debug)]
pub struct BandTrace {
    stretch: usize,
    taken: usize,
    widest: Option<(f64, f64, f64)>,
    points: Vec<(f64, f64, f64)>,
}

impl BandTrace {
    /// Creates an empty band. The expected number of samples, `count`, determines the size of the
    /// groups.
    pub fn new(count: usize) -> Self {
        Self { stretch: count.div_ceil(DRAWN).max(1), taken: 0, widest: None, points: Vec::new() }
    }

    /// Adds a sample at a time (s). A sample may have no interval (`None`); a group of such samples
    /// interrupts the band.
    pub fn push(&mut self, time: f64, interval: Option<(f64, f64)>) {
        if let Some((low, high)) = interval
            && self.widest.is_none_or(|(_, a, b)| high - low > b - a)
        {
            self.widest = Some((time, low, high));
        }
        self.taken += 1;
        if self.taken == self.stretch {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.taken = 0;
        match self.widest.take() {
            Some(point) => self.points.push(point),
            None if self.points.last().is_some_and(|point| !point.0.is_nan()) => {
                self.points.push((f64::NAN, f64::NAN, f64::NAN));
            }
            None => {}
        }
    }

    /// Converts the samples to a band; `None` if no sample had an interval.
    pub fn band(mut self, label: &str, colour: usize) -> Option<Band> {
        self.flush();
        let label = label.to_owned();
        (!self.points.is_empty()).then_some(Band { label, points: self.points, colour })
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

    /// Checks that Coulomb friction which reverses between two samples is drawn as a vertical step
    /// at the reversal.
    #[test]
    fn reversals_are_steps() {
        let mut trace = JumpTrace::new(4);
        let velocity = |t: f64| 1.5 - t;
        let mut last = None;
        for k in 0..4 {
            let t = f64::from(k);
            let crossing = last.and_then(|before| reversal(before, (t, velocity(t))));
            trace.push(t, 10.0, 2.0 * velocity(t).signum(), false, crossing);
            last = Some((t, velocity(t)));
        }
        let points = trace.line("", 0, false).points;
        assert_eq!(
            points,
            [(0.0, 12.0), (1.0, 12.0), (1.5, 12.0), (1.5, 8.0), (2.0, 8.0), (3.0, 8.0)]
        );
    }

    /// Checks that both sides of a jump follow the curve, and that a quantity without a jump has no
    /// step.
    #[test]
    fn jumps_join_sloping_curves() {
        let run = |value: fn(f64) -> f64| {
            let mut trace = JumpTrace::new(5);
            for k in 0..5 {
                let t = f64::from(k);
                trace.push(t, 0.0, value(t), false, (k == 3).then_some(2.25));
            }
            trace.line("", 0, false).points
        };
        let jump = run(|t| t + if t < 2.25 { 0.0 } else { 10.0 });
        assert_eq!(jump[3..5], [(2.25, 2.25), (2.25, 12.25)]);
        let smooth = run(|t| 3.0 * t);
        assert!(smooth.iter().all(|(t, y)| *y == 3.0 * t), "{smooth:?}");
    }

    /// Checks that a single sample at rest causes no spike, and that a longer rest interrupts the
    /// curve.
    #[test]
    fn rest_is_no_spike() {
        let run = |rests: [bool; 4], parts: [f64; 4]| {
            let mut trace = JumpTrace::new(4);
            for k in 0..4 {
                trace.push(k as f64, 0.0, parts[k], rests[k], None);
            }
            let points = trace.line("", 0, false).points;
            points
                .into_iter()
                .map(|(x, y)| if x.is_nan() { (-1.0, -1.0) } else { (x, y) })
                .collect::<Vec<_>>()
        };
        let lone = run([false, true, false, false], [1.0, 0.0, -1.0, -1.0]);
        assert_eq!(lone, [(0.0, 1.0), (1.0, 1.0), (1.0, -1.0), (2.0, -1.0), (3.0, -1.0)]);
        let dwell = run([false, true, true, false], [1.0, 0.0, 0.0, -1.0]);
        assert_eq!(dwell, [(0.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (2.0, -1.0), (3.0, -1.0)]);
    }

    #[test]
    fn bands_keep_the_widest_intervals() {
        let mut band = BandTrace::new(100_000);
        for k in 0..100_000 {
            let wide = if k == 50_001 { 9.0 } else { 1.0 };
            band.push(k as f64, (k % 70_000 > 1000).then_some((-wide, wide)));
        }
        let points = band.band("", 0).unwrap().points;
        assert!(points.len() <= DRAWN + 2 && points.iter().any(|p| p.2 == 9.0));
        assert!(points.iter().any(|p| p.0.is_nan()));
        assert!(BandTrace::new(3).band("", 0).is_none());
    }
}
