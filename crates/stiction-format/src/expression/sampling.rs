//! Sampling limits of formulas of time: times up to which a few samples are enough to resolve
//! sines, ramps, kinks and peaks.
//!
//! A simulation evaluates a formula only at few instants and could miss a short pulse. The
//! functions below predict the next feature of each operation from the value and the derivatives of
//! the operation's argument.

use super::function::Function;
use super::jet::Jet;
use super::parse::Op;
use super::run::Formula;
use std::f64::consts::FRAC_PI_4;

/// Argument below which `exp` is negligible: e^-50 is 2e-22.
const EXP_NEGLIGIBLE: f64 = -50.0;
/// Magnitude of the argument above which sigmoids count as constant: 1 - tanh 20 is 8e-18.
const SIGMOID_LIMIT: f64 = 20.0;
/// Number of samples across a ramp of the function `smooth`.
const RAMP_SAMPLES: f64 = 4.0;
/// Features that follow the current time t by less than this fraction of max(|t|, 1 s) count as
/// past.
const TIME_RESOLUTION: f64 = 1e-13;

impl Formula {
    /// Returns a time, s, after `t` (s) such that a few samples between both times resolve the
    /// formula.
    pub(crate) fn resolved_until(&self, t: f64) -> f64 {
        let mut soonest = f64::INFINITY;
        let now = TIME_RESOLUTION * t.abs().max(1.0);
        self.visit(t, &mut |op, arguments| {
            let within = within(op, arguments, now);
            if within > now {
                soonest = soonest.min(within);
            }
        });
        t + soonest
    }
}

/// Returns the duration, s, from the current time, within which a few samples resolve the result of
/// an operation; infinite if the operation has no features. Features that follow within `now`, s,
/// count as past.
fn within(op: Op, arguments: &[Jet], now: f64) -> f64 {
    let argument = |k: usize| arguments.get(k).copied().unwrap_or(Jet::constant(0.0));
    let a = argument(0);
    match op {
        // Poles lie at the zeros of a divisor.
        Op::Divide => 0.5 * until_zero(argument(1)),
        Op::Power if argument(1).value < 0.0 => 0.5 * until_zero(a),
        Op::Call(function, _) => match function {
            Function::Sin | Function::Cos | Function::Tan => until_changed_by(a, FRAC_PI_4),
            Function::Exp | Function::Sinh | Function::Cosh => {
                let size = if function == Function::Exp { a } else { a.abs() };
                until_steep(size, size.value - EXP_NEGLIGIBLE)
            }
            Function::Tanh | Function::Atan | Function::Atan2 => {
                let a = if function == Function::Atan2 { a / argument(1) } else { a };
                until_steep(-a.abs(), SIGMOID_LIMIT - a.value.abs())
            }
            Function::Smooth => {
                let along = (a - argument(1)) / (argument(2) - argument(1));
                let from = until_zero(along);
                let to = until_zero(along - Jet::constant(1.0));
                let ends = [from, to].into_iter().filter(|end| *end > now);
                let next = ends.fold(f64::INFINITY, f64::min);
                let ramp = (0.0..1.0).contains(&along.value);
                if ramp { next.min(until_changed_by(along, RAMP_SAMPLES.recip())) } else { next }
            }
            Function::Abs => until_met(a, now),
            Function::Min | Function::Max => {
                let chosen = Function::apply(function, arguments);
                let meetings = arguments.iter().map(|other| until_met(chosen - *other, now));
                meetings.fold(f64::INFINITY, f64::min)
            }
            _ => f64::INFINITY,
        },
        _ => f64::INFINITY,
    }
}

/// Time, s, until a number reaches zero at its present rate; infinite if the number moves away from
/// zero.
fn until_zero(x: Jet) -> f64 {
    let until = -x.value / x.first;
    if until > 0.0 { until } else { f64::INFINITY }
}

/// Time, s, until a number reaches zero or its rate changes sign, extrapolated with the present
/// rate and acceleration. Events that follow within `now`, s, count as past.
fn until_met(x: Jet, now: f64) -> f64 {
    let root = (x.first * x.first - 2.0 * x.value * x.second).sqrt();
    // Choose the form of the root without cancellation.
    let sum = x.first + root.copysign(x.first);
    let roots = [-2.0 * x.value / sum, -sum / x.second];
    let all = [until_zero(x), roots[0], roots[1], -x.first / x.second];
    all.into_iter().filter(|within| *within > now).fold(f64::INFINITY, f64::min)
}

/// Time, s, until a number changes by the given amount, extrapolated with the present rate and
/// acceleration of the number.
fn until_changed_by(x: Jet, change: f64) -> f64 {
    (change / x.first.abs()).min((2.0 * change / x.second.abs()).sqrt())
}

/// Time, s, until the argument `size` of a steep function changes by one. `above` is the difference
/// between `size` and the threshold below which the function is constant or negligible. If `above`
/// is negative, the result is at least the time until `size` reaches the threshold.
fn until_steep(size: Jet, above: f64) -> f64 {
    if above >= 0.0 {
        return until_changed_by(size, 1.0);
    }
    let by_rate = if size.first > 0.0 { -above / size.first } else { f64::INFINITY };
    let by_acceleration =
        if size.second > 0.0 { (-2.0 * above / size.second).sqrt() } else { f64::INFINITY };
    // Waits until the argument has changed by the missing amount, but at least until it has changed by one, so that
    // steps shrink near the feature.
    by_rate.min(by_acceleration).max(until_changed_by(size, 1.0))
}

#[cfg(test)]
mod tests {
    use crate::expression::tests::formula;

    /// Samples a formula at successive sampling limits from time 0 to `end`, s. Returns the
    /// greatest absolute value among the samples, and the number of samples.
    fn most(text: &str, end: f64) -> (f64, usize) {
        let formula = formula(text);
        let (mut t, mut most, mut samples) = (0.0, 0.0_f64, 0);
        while t < end {
            most = most.max(formula.at(t).value.abs());
            let next = formula.resolved_until(t).min(end);
            assert!(next > t, "{text} at {t}");
            (t, samples) = (next, samples + 1);
            assert!(samples < 10_000, "{text} at {t}");
        }
        (most, samples)
    }

    /// Checks that a pulse of height 1 and a width of about 2 ms within 10 s is sampled near its
    /// maximum, with few samples.
    #[test]
    fn short_pulses_are_resolved() {
        for text in [
            "smooth(t, 7, 7.001) - smooth(t, 7.001, 7.002)",
            "max(0, 1 - abs(t - 7)/0.001)",
            "exp(-((t - 7)/0.0003)^2)",
            "0.5*(tanh((t - 7)/0.0001) - tanh((t - 7.001)/0.0001))",
            "1/(1 + ((t - 7)/0.0001)^2)",
            // Pulses of 2 ms width at the peak of a slow wave.
            "max(0, cos(0.9*(t - 7)) - cos(0.0009))/(1 - cos(0.0009))",
            "(abs(cos(0.9*(t - 7)) - cos(0.0009)) + cos(0.9*(t - 7)) - cos(0.0009))/(2 - 2*cos(0.0009))",
        ] {
            let (most, samples) = most(text, 10.0);
            assert!(most > 0.7, "{text}: {most}");
            // Uniform sampling at the width of the pulse would need 5000 samples.
            assert!(samples < 300, "{text}: {samples}");
        }
    }

    /// Checks that oscillations of constant or increasing frequency are sampled about eight times
    /// per period.
    #[test]
    fn oscillations_are_resolved() {
        for (text, turns) in [("sin(2*pi*50*t)", 500.0), ("cos(2*pi*10*t^2)", 1000.0)] {
            let (most, samples) = most(text, 10.0);
            assert!(most > 0.9, "{text}: {most}");
            let samples = samples as f64 / turns;
            assert!((7.9..12.0).contains(&samples), "{text}: {samples}");
        }
    }

    #[test]
    fn smooth_formulas_have_no_limit() {
        for text in ["2*t + 1", "t^2", "smooth(t, -2, -1)", "abs(t + 1)"] {
            assert_eq!(formula(text).resolved_until(0.5), f64::INFINITY, "{text}");
        }
    }
}
