//! Motion laws: the position in a move from rest to rest as a function of time.

/// Motion law of a move from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// Polynomial of degree five; acceleration zero at both ends.
    Quintic,
    /// Cycloid: the acceleration is one period of a sine.
    Cycloid,
    /// Modified sine: sines of two frequencies, with smaller peaks than the cycloid.
    ModifiedSine,
    /// Constant acceleration, constant speed, constant deceleration.
    Trapezoid,
    /// Like the trapezoid, but with limited jerk: seven phases of constant jerk.
    SCurve,
}

/// Limits or peak values of speed, acceleration and jerk, in this order; an infinite value means no
/// limit.
pub(crate) type Limits = [f64; 3];

/// Limits of infinite speed, acceleration and jerk.
pub(crate) const UNLIMITED: Limits = [f64::INFINITY; 3];

impl Law {
    /// Names of the laws in the model file.
    pub(crate) const NAMES: &[&str] =
        &["quintic", "cycloid", "modified-sine", "trapezoid", "s-curve"];

    /// The laws in the order of their names.
    const ALL: [Self; 5] =
        [Self::Quintic, Self::Cycloid, Self::ModifiedSine, Self::Trapezoid, Self::SCurve];

    /// Returns the law with this name.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        let index = Self::NAMES.iter().position(|known| *known == name)?;
        Self::ALL.get(index).copied()
    }

    /// Name of the law in the model file.
    pub(crate) fn name(self) -> &'static str {
        let index = Self::ALL.iter().position(|law| *law == self);
        index.and_then(|index| Self::NAMES.get(index)).copied().unwrap_or_default()
    }

    /// Limits, in words, that the law needs for a shortest duration to exist.
    pub(crate) fn needs(self) -> &'static str {
        match self {
            Self::Quintic | Self::Cycloid | Self::ModifiedSine => "a limit",
            Self::Trapezoid => "a limit of the acceleration",
            Self::SCurve => "a limit of the jerk",
        }
    }

    /// Peak speed, acceleration and jerk of a smooth law for a move over unit distance in unit
    /// time; `None` for a law with phases.
    fn unit_peaks(self) -> Option<Limits> {
        use std::f64::consts::{PI, TAU};
        match self {
            Self::Quintic => Some([1.875, 10.0 / 3f64.sqrt(), 60.0]),
            Self::Cycloid => Some([2.0, TAU, TAU * TAU]),
            Self::ModifiedSine => {
                let scale = 1.0 / (4.0 + PI);
                Some([4.0 * PI * scale, 4.0 * PI * PI * scale, 16.0 * PI.powi(3) * scale])
            }
            Self::Trapezoid | Self::SCurve => None,
        }
    }
}

/// A move over unit distance from rest to rest.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pub(crate) duration: f64,
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    Smooth(Law),
    /// Phases of constant jerk in order of time, scaled to a move of unit duration.
    Pieces(Vec<Piece>),
}

/// Phase of constant jerk. `begin` is the fraction of the move at which the phase begins; `state`
/// is the position, speed and acceleration at its beginning.
#[derive(Clone, Copy, Debug)]
struct Piece {
    begin: f64,
    state: [f64; 3],
    jerk: f64,
}

impl Profile {
    /// Creates the fastest move over unit distance within limits; `None` if the law has no shortest
    /// duration under these limits.
    pub(crate) fn fastest(law: Law, limits: Limits) -> Option<Self> {
        let [speed, acceleration, jerk] = limits;
        if let Some([v, a, j]) = law.unit_peaks() {
            let duration = (v / speed).max((a / acceleration).sqrt()).max((j / jerk).cbrt());
            return (duration > 0.0).then_some(Self { duration, shape: Shape::Smooth(law) });
        }
        if law == Law::Trapezoid {
            if acceleration.is_infinite() {
                return None;
            }
            // Without a phase of constant speed, the peak speed is sqrt(acceleration).
            let peak = speed.min(acceleration.sqrt());
            let ramp = peak / acceleration;
            return Some(Self::trapezoid(ramp, 1.0 / peak - ramp));
        }
        if jerk.is_infinite() {
            return None;
        }
        // Greatest acceleration that the distance and the limits of acceleration and jerk permit.
        // The speed limit may shorten the jerk phase further.
        let reached = acceleration.min((jerk * jerk / 2.0).cbrt());
        let step = (reached / jerk).min((speed / jerk).sqrt());
        let peak = jerk * step;
        // Time of constant acceleration: until the speed limit or half the distance is reached.
        let by_speed = speed / peak - step;
        let by_distance = -1.5 * step + (0.25 * step * step + 1.0 / peak).sqrt();
        let hold = by_speed.min(by_distance).max(0.0);
        let cruise_speed = peak * (step + hold);
        let cruise = (1.0 / cruise_speed - (2.0 * step + hold)).max(0.0);
        Some(Self::s_curve(step, hold, cruise))
    }

    /// Creates a trapezoid or s-curve of unit duration. `ramp` is the duration of the acceleration,
    /// up to 0.5, and `step` that of each jerk phase as a fraction of `ramp`, up to 0.5.
    pub(crate) fn of_phases(law: Law, ramp: f64, step: f64) -> Self {
        let cruise = 1.0 - 2.0 * ramp;
        match law {
            Law::SCurve => Self::s_curve(step * ramp, (1.0 - 2.0 * step) * ramp, cruise),
            _ => Self::trapezoid(ramp, cruise),
        }
    }

    /// Greatest speed, acceleration and jerk of the move over unit distance.
    pub(crate) fn peaks(&self) -> Limits {
        let unit = match &self.shape {
            Shape::Smooth(law) => law.unit_peaks().unwrap_or_default(),
            Shape::Pieces(pieces) => {
                let jumps = pieces.iter().all(|piece| piece.jerk == 0.0);
                let most = |value: &dyn Fn(&Piece) -> f64| {
                    pieces.iter().map(|piece| value(piece).abs()).fold(0.0, f64::max)
                };
                let jerk = if jumps { f64::INFINITY } else { most(&|piece| piece.jerk) };
                [most(&|piece| piece.state[1]), most(&|piece| piece.state[2]), jerk]
            }
        };
        let [v, a, j] = unit;
        [v / self.duration, a / self.duration.powi(2), j / self.duration.powi(3)]
    }

    /// Scales the profile in time to another duration.
    pub(crate) fn stretched(self, duration: f64) -> Self {
        Self { duration, ..self }
    }

    /// Creates a move of a given duration, s, without regard to limits.
    pub(crate) fn lasting(law: Law, duration: f64) -> Self {
        let profile = match law {
            Law::Trapezoid => Self::trapezoid(1.0, 1.0),
            Law::SCurve => Self::s_curve(1.0, 1.0, 3.0),
            law => Self { duration, shape: Shape::Smooth(law) },
        };
        Self { duration, ..profile }
    }

    /// Creates the profile of a trapezoid from the durations of a ramp and of the phase of constant
    /// speed.
    fn trapezoid(ramp: f64, cruise: f64) -> Self {
        let acceleration = 1.0 / (ramp * (ramp + cruise));
        Self::of_accelerations(&[
            (ramp, acceleration, 0.0),
            (cruise, 0.0, 0.0),
            (ramp, -acceleration, 0.0),
        ])
    }

    /// Creates the profile of an s-curve from the durations of a jerk phase, of a phase of constant
    /// acceleration, and of the phase of constant speed.
    fn s_curve(step: f64, hold: f64, cruise: f64) -> Self {
        let ramp = 2.0 * step + hold;
        let jerk = 1.0 / (step * (step + hold) * (ramp + cruise));
        let peak = jerk * step;
        Self::of_accelerations(&[
            (step, 0.0, jerk),
            (hold, peak, 0.0),
            (step, peak, -jerk),
            (cruise, 0.0, 0.0),
            (step, 0.0, -jerk),
            (hold, -peak, 0.0),
            (step, -peak, jerk),
        ])
    }

    /// Creates a profile from the duration, initial acceleration and jerk of each phase.
    fn of_accelerations(phases: &[(f64, f64, f64)]) -> Self {
        let duration: f64 = phases.iter().map(|(time, ..)| time).sum();
        let (mut pieces, mut begin, mut position, mut speed) = (Vec::new(), 0.0, 0.0, 0.0);
        for &(time, acceleration, jerk) in phases {
            // Scaled to unit duration, derivatives grow with the corresponding power of the duration.
            let (acceleration, jerk) = (acceleration * duration.powi(2), jerk * duration.powi(3));
            let piece = Piece { begin, state: [position, speed, acceleration], jerk };
            begin += time / duration;
            let end = piece.at(begin);
            (position, speed) = (end[0], end[1]);
            pieces.push(piece);
        }
        Self { duration, shape: Shape::Pieces(pieces) }
    }

    /// Position between 0 and 1 and its first and second derivatives at a time, s, after the
    /// beginning of the move.
    pub(crate) fn at(&self, time: f64) -> [f64; 3] {
        if time <= 0.0 {
            return [0.0; 3];
        }
        if time >= self.duration {
            return [1.0, 0.0, 0.0];
        }
        let [s, v, a, _] = self.unit(self.phase(time), time / self.duration);
        [s, v / self.duration, a / (self.duration * self.duration)]
    }

    /// Returns the index of the phase at a time, s, after the beginning of the move. The jerk
    /// may jump at the end of a phase.
    pub(crate) fn phase(&self, time: f64) -> usize {
        let x = time / self.duration;
        match &self.shape {
            Shape::Pieces(pieces) => pieces.partition_point(|piece| piece.begin <= x).max(1) - 1,
            Shape::Smooth(Law::ModifiedSine) => usize::from(x >= 0.125) + usize::from(x > 0.875),
            Shape::Smooth(_) => 0,
        }
    }

    /// Returns the times, s, at which the phases begin, and the time at which the last phase ends.
    /// Times count from the beginning of the move.
    pub(crate) fn phases(&self) -> Vec<f64> {
        let mut begins: Vec<f64> = match &self.shape {
            Shape::Pieces(pieces) => pieces.iter().map(|piece| piece.begin).collect(),
            Shape::Smooth(Law::ModifiedSine) => vec![0.0, 0.125, 0.875],
            Shape::Smooth(_) => vec![0.0],
        };
        begins.push(1.0);
        begins.iter().map(|begin| begin * self.duration).collect()
    }

    /// Position between 0 and 1 and its first three derivatives at a time, s, after the beginning
    /// of the move, evaluated by the formula of a phase, also outside this phase.
    pub(crate) fn in_phase(&self, phase: usize, time: f64) -> [f64; 4] {
        let [s, v, a, j] = self.unit(phase, time / self.duration);
        let rate = self.duration.recip();
        [s, v * rate, a * rate * rate, j * rate * rate * rate]
    }

    /// Position and its first three derivatives at the fraction `x` of a move of unit duration,
    /// evaluated by the formula of a phase, also outside this phase.
    fn unit(&self, phase: usize, x: f64) -> [f64; 4] {
        use std::f64::consts::{PI, TAU};
        match &self.shape {
            Shape::Smooth(Law::Cycloid) => {
                let (sine, cosine) = (TAU * x).sin_cos();
                [x - sine / TAU, 1.0 - cosine, TAU * sine, TAU * TAU * cosine]
            }
            Shape::Smooth(Law::ModifiedSine) => {
                let scale = 1.0 / (4.0 + PI);
                // The sine has the period 1/2 in the first and the last eighth of the move, and 3/2
                // between them.
                let (offset, size, rate, begin) = match phase {
                    0 => (0.0, 0.25, 4.0 * PI, 0.0),
                    1 => (2.0, 2.25, 4.0 * PI / 3.0, PI / 3.0),
                    _ => (4.0, 0.25, 4.0 * PI, 0.0),
                };
                let (sine, cosine) = (rate * x + begin).sin_cos();
                [
                    (offset + PI * x - size * sine) * scale,
                    (PI - size * rate * cosine) * scale,
                    size * rate * rate * sine * scale,
                    size * rate.powi(3) * cosine * scale,
                ]
            }
            Shape::Smooth(_) => {
                let y = 1.0 - x;
                let s = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
                [s, 30.0 * x * x * y * y, 60.0 * x * y * (y - x), 60.0 * (1.0 - 6.0 * x * y)]
            }
            Shape::Pieces(pieces) => pieces.get(phase).map_or([0.0; 4], |piece| {
                let [s, v, a] = piece.at(x);
                [s, v, a, piece.jerk]
            }),
        }
    }

    /// Returns times, s, after the beginning of the move, which divide it into intervals. A few
    /// samples resolve the move in each interval.
    pub(crate) fn knots(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Smooth(_) => (1..4).map(|k| self.duration * f64::from(k) / 4.0).collect(),
            Shape::Pieces(pieces) => {
                pieces.iter().skip(1).map(|piece| piece.begin * self.duration).collect()
            }
        }
    }
}

impl Piece {
    fn at(&self, x: f64) -> [f64; 3] {
        let h = x - self.begin;
        let [s, v, a] = self.state;
        [
            s + h * (v + h * (a / 2.0 + h * self.jerk / 6.0)),
            v + h * (a + h * self.jerk / 2.0),
            a + h * self.jerk,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that derivatives agree with differences of the position, and that every move begins
    /// and ends at rest.
    #[test]
    fn laws_go_from_rest_to_rest_with_exact_derivatives() {
        for law in Law::ALL {
            let profile = Profile::lasting(law, 0.7);
            let begin = profile.unit(0, 0.0);
            assert!(begin[0].abs() < 1e-15 && begin[1].abs() < 1e-15);
            let end = profile.unit(profile.phase(0.7), 1.0);
            assert!((end[0] - 1.0).abs() < 1e-14 && end[1].abs() < 1e-13, "{law:?}: {end:?}");
            for k in 1..100 {
                // These times avoid the corners of the acceleration.
                let (t, h) = (0.7 * (f64::from(k) + 0.37) / 101.0, 1e-6);
                let phase = profile.phase(t);
                let [low, middle, high] = [t - h, t, t + h].map(|t| profile.in_phase(phase, t));
                for d in 0..3 {
                    let slope = (high[d] - low[d]) / (2.0 * h);
                    assert!((slope - middle[d + 1]).abs() < 1e-5, "{law:?} at {t}");
                }
                let at = profile.at(t);
                assert!((0..3).all(|d| (at[d] - middle[d]).abs() <= 1e-14 * middle[d].abs()));
            }
        }
    }

    /// Checks that the fastest move reaches a limit exactly and exceeds none.
    #[test]
    fn limits_are_reached_and_not_exceeded() {
        let limits = [[0.5, 3.0, 40.0], [5.0, 3.0, 40.0], [5.0, 30.0, 40.0], [0.5, 30.0, 4.0]];
        for (law, limits) in Law::ALL.iter().flat_map(|law| limits.map(|l| (*law, l))) {
            let profile = Profile::fastest(law, limits).unwrap();
            let peaks = profile.peaks();
            let ratios: Vec<f64> =
                (0..3).filter(|&k| peaks[k].is_finite()).map(|k| peaks[k] / limits[k]).collect();
            let most = ratios.iter().copied().fold(0.0, f64::max);
            assert!((most - 1.0).abs() < 1e-12, "{law:?} {limits:?}: {ratios:?}");
            // The peaks computed from the phases are those of the sampled move.
            let mut seen = [0f64; 2];
            for k in 0..=100_000 {
                let at = profile.at(profile.duration * f64::from(k) / 1e5);
                seen = [seen[0].max(at[1].abs()), seen[1].max(at[2].abs())];
            }
            for k in 0..2 {
                assert!(seen[k] <= peaks[k] * (1.0 + 1e-12), "{law:?} {limits:?}");
                assert!(seen[k] >= peaks[k] * (1.0 - 1e-3), "{law:?} {limits:?}");
            }
        }
    }

    /// Checks the shortest durations over unit distance against textbook formulas:
    ///
    /// - trapezoid: 1/v + v/a;
    /// - triangle: 2/sqrt(a);
    /// - full s-curve: 1/v + v/a + a/j;
    /// - s-curve of four jerk phases: 4 (1/(2 j))^(1/3).
    #[test]
    fn durations_are_the_shortest() {
        let time = |law, limits| Profile::fastest(law, limits).unwrap().duration;
        let none = f64::INFINITY;
        for (law, limits, expected) in [
            (Law::Trapezoid, [1.0, 5.0, none], 1.2),
            (Law::Trapezoid, [9.0, 4.0, none], 1.0),
            (Law::SCurve, [1.0, 5.0, 50.0], 1.3),
            (Law::SCurve, [none, none, 32.0], 1.0),
            (Law::SCurve, [none, 1e9, 32.0], 1.0),
            // Without constant acceleration: two jerk phases of sqrt(v/j) for each speed change.
            (Law::SCurve, [1.0, 5.0, 16.0], 1.5),
        ] {
            let found = time(law, limits);
            assert!((found - expected).abs() < 1e-12, "{law:?} {limits:?}: {found}");
        }
        assert!(Profile::fastest(Law::Trapezoid, [1.0, none, none]).is_none());
        assert!(Profile::fastest(Law::SCurve, [1.0, 1.0, none]).is_none());
        assert!(Profile::fastest(Law::Quintic, UNLIMITED).is_none());
    }
}
