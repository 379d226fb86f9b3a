//! Shortest moves within limits of coordinates, which are linear in the path parameter, and of joints, which are not.

use super::curve::{Curve, largest, minimum};
use crate::signal::law::{Law, Limits, Profile};

/// Number of steps in each search for the phases of a trapezoid or s-curve. The minimum duration is accurate to about
/// 1e-6, because it changes little near its minimum.
const STEPS: usize = 22;
/// Shortest ramp as a fraction of the move, and shortest jerk phase as a fraction of the ramp.
const SHORTEST: f64 = 1e-3;

/// Returns the fastest move; `None` if the law has no shortest duration. `straight` are limits for unit distance.
///
/// Smooth laws are scaled in time. For the other laws, the phases are those of the shortest move. At least one limit
/// is reached, and none is exceeded.
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

/// Computes the magnitudes of three vectors from their components.
pub(super) fn magnitudes(components: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    components.fold([0.0; 3], |sum: [f64; 3], each| [0, 1, 2].map(|k| sum[k].hypot(each[k])))
}

/// Shortest duration, s, within the limits of a move that has these peaks if it lasts 1 s.
fn duration(peaks: Limits, limits: Limits) -> f64 {
    let ratio = |d: usize| if limits[d].is_finite() { peaks[d] / limits[d] } else { 0.0 };
    ratio(0).max(ratio(1).sqrt()).max(ratio(2).cbrt())
}

/// Greatest speed, acceleration and jerk of a quantity during a move with this profile; `curves` are its components
/// as functions of the path parameter, which the profile moves from 0 to 1.
pub(super) fn peaks(curves: &[Curve], profile: &Profile, exact: bool) -> Limits {
    let phases = profile.phases();
    // Corners, each with the phase that follows it.
    let mut corners: Vec<(f64, usize)> = Vec::new();
    for (phase, pair) in phases.windows(2).enumerate() {
        if pair[1] > pair[0] {
            corners.push((pair[0], phase));
        }
    }
    // All components have the same pieces.
    for part in curves.iter().take(1).flat_map(Curve::joints) {
        // Time at which the path parameter has this value.
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
