//! Shortest moves within limits of coordinates and of joints. Coordinates are linear in the path
//! parameter of a move; joint positions are not.

use super::curve::{Curve, largest, minimum};
use crate::signal::law::{Law, Limits, Profile};

/// Number of steps of each golden-section search for the phases of a trapezoid or s-curve. The
/// minimum duration is accurate to about 1e-6, because it changes little near its minimum.
const STEPS: usize = 22;
/// Lower bound in the search for the phases: of the ramp as a fraction of the move, and of the jerk
/// phase as a fraction of the ramp.
const SHORTEST: f64 = 1e-3;

/// Returns the fastest move with a motion law; `None` if the law has no shortest duration within
/// the limits. `straight` are the limits of the path parameter, which moves from 0 to 1. `curves`
/// are the components of further quantities as functions of the path parameter, with the limits of
/// each quantity.
///
/// Smooth laws are scaled in time. For a trapezoid or s-curve, the durations of the phases are
/// those of the shortest move. The move reaches at least one limit and exceeds none.
pub(super) fn fastest(
    law: Law,
    straight: Limits,
    curves: &[(&[Curve], Limits)],
) -> Option<Profile> {
    if curves.is_empty() {
        return Profile::fastest(law, straight);
    }
    let limited = |d: usize| {
        straight[d].is_finite() || curves.iter().any(|(_, limits)| limits[d].is_finite())
    };
    let least = |profile: &Profile, exact: bool| {
        let own = duration(profile.peaks(), straight);
        let each =
            curves.iter().map(|(curve, limits)| duration(peaks(curve, profile, exact), *limits));
        each.fold(own, f64::max)
    };
    let quick = |ramp: f64, step: f64| least(&Profile::of_phases(law, ramp, step), false);
    let profile = match law {
        Law::Trapezoid if limited(1) => {
            let ramp = minimum((SHORTEST, 0.5), STEPS, |ramp| quick(ramp, 0.5));
            Profile::of_phases(law, ramp, 0.5)
        }
        Law::SCurve if limited(2) => {
            let best = |ramp: f64| minimum((SHORTEST, 0.5), STEPS, |step| quick(ramp, step));
            let ramp = minimum((SHORTEST, 0.5), STEPS, |ramp| quick(ramp, best(ramp)));
            Profile::of_phases(law, ramp, best(ramp))
        }
        Law::Trapezoid | Law::SCurve => return None,
        smooth => Profile::lasting(smooth, 1.0),
    };
    let duration = least(&profile, true);
    (duration > 0.0).then(|| profile.stretched(duration))
}

/// Computes the magnitudes of three vectors. Each item of `components` contains one component of
/// all three.
pub(super) fn magnitudes(components: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    components.fold([0.0; 3], |sum: [f64; 3], each| [0, 1, 2].map(|k| sum[k].hypot(each[k])))
}

/// Returns the shortest duration, s, of a move within `limits`. `peaks` are the greatest speed,
/// acceleration and jerk of the move if it lasts 1 s.
fn duration(peaks: Limits, limits: Limits) -> f64 {
    let ratio = |d: usize| if limits[d].is_finite() { peaks[d] / limits[d] } else { 0.0 };
    ratio(0).max(ratio(1).sqrt()).max(ratio(2).cbrt())
}

/// Returns the greatest speed, acceleration and jerk of a quantity during a move. `curves` are the
/// components of the quantity as functions of the path parameter. During the move, `profile`
/// changes the path parameter from 0 to 1. If `exact` is false, only some samples are compared.
pub(super) fn peaks(curves: &[Curve], profile: &Profile, exact: bool) -> Limits {
    let phases = profile.phases();
    // Times, s, of the corners of the motion, each with the index of the phase that follows it.
    let mut corners: Vec<(f64, usize)> = Vec::new();
    for (phase, pair) in phases.windows(2).enumerate() {
        if pair[1] > pair[0] {
            corners.push((pair[0], phase));
        }
    }
    // The curves of all components are divided into the same pieces.
    for part in curves.iter().take(1).flat_map(Curve::joints) {
        // Bisect for the time at which the path parameter has the value `part`.
        let (mut low, mut high) = (0.0, profile.duration);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if profile.at(middle)[0] < part { low = middle } else { high = middle }
        }
        corners.push((low, profile.phase(low)));
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let times: Vec<f64> = corners.iter().map(|(time, _)| *time).chain([profile.duration]).collect();
    largest(&times, exact, |interval, time| {
        let [part, v, a, j] = profile.in_phase(corners[interval].1, time);
        let each = curves.iter().map(|curve| {
            let [first, second, third] = curve.at(part.clamp(0.0, 1.0));
            [
                first * v,
                second * v * v + first * a,
                third * v.powi(3) + 3.0 * second * v * a + first * j,
            ]
        });
        magnitudes(each)
    })
}
