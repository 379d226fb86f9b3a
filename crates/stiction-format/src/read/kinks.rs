//! Warnings about jumps of the rates that a motion prescribes.

use super::motion::STEP;
use crate::diagnostic::{Diagnostic, number};
use crate::expression::Measure;
use crate::model_file::Motion;
use crate::signal::RateJump;

/// Largest number of intervals of a motion that are searched for jumps.
const INTERVALS: f64 = 10_000.0;

/// Adds a warning to the motion for each coordinate whose rate jumps. `labels` contains the name
/// and the kind of each coordinate.
pub(super) fn warn_of_jumps(motion: &mut Motion, labels: &[(String, Measure)]) {
    let (start, duration) = (motion.start, motion.duration);
    let step = motion.step.unwrap_or(STEP).max(duration / INTERVALS);
    for ((_, signal), (name, measure)) in motion.coordinates.iter().zip(labels) {
        let jumps = signal.rate_jumps(start, duration, step);
        let size = |jump: &RateJump| (jump.after - jump.before).abs();
        let most = jumps.iter().map(size).fold(0.0, f64::max);
        // The first of jumps that differ by rounding errors only.
        let Some(largest) = jumps.iter().find(|jump| size(jump) >= 0.999 * most) else { continue };
        let unit = if *measure == Measure::Length { "m/s" } else { "rad/s" };
        let more = match jumps.len() - 1 {
            0 => String::new(),
            1 => ", and at one more instant".to_owned(),
            count => format!(", and at {count} more instants"),
        };
        let message = format!(
            "the rate of `{name}` jumps from {} to {} {unit} at t = {} s{more}: this needs an infinite effort, \
             which the results do not show",
            rounded(largest.before),
            rounded(largest.after),
            rounded(largest.time),
        );
        motion
            .warnings
            .push(Diagnostic::warning("motion", message).help(
                "prescribe a motion without kinks, for example with `smooth` or `waypoints`",
            ));
    }
}

/// Returns a number with six significant digits, because jumps are located by bisection.
fn rounded(x: f64) -> String {
    number(format!("{x:.5e}").parse().unwrap_or(x))
}
