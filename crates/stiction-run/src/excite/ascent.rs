//! Search for the motion with the most information about the parameters: quasi-Newton ascents
//! (BFGS) that stay within the limits, and random trials between the ascents.
//!
//! Beyond a limit the objective is undefined, so a step across a limit is halved. Dry friction
//! changes its sign between samples of the time grid, so the objective jumps, and an ascent may
//! stop at a jump. Random trials continue from the point where an ascent stops. Their size
//! increases after a success and decreases after a failure.
//!
//! Sources: Nocedal and Wright, *Numerical Optimization* (2006), algorithm 6.1 with backtracking;
//! Rechenberg, *Evolutionsstrategie* (1973), the one-fifth rule.

use super::objective::{Objective, Sweep};
use nalgebra::{DMatrix, DVector};
use stiction_core::random::Random;

/// Smallest gain for which a step is accepted, as a fraction of the gain that the slope predicts
/// (Armijo's rule).
const SUFFICIENT: f64 = 1e-4;
/// Number of times that a step is halved before the ascent ends.
const HALVINGS: usize = 25;
/// Increase of the objective, divided by the number of base parameters, below which the ascent
/// ends.
const SETTLED: f64 = 1e-4;
/// Length of the first step of an ascent, as a fraction of the largest coefficient.
const FIRST: f64 = 0.1;

/// Number of random trials after an ascent.
const TRIALS: usize = 24;
/// Number of search steps that are counted for all random trials after one ascent together.
const TRIALS_AS_STEPS: usize = 3;
/// Size of the first random trial, as a fraction of the root mean square of the coefficients.
const TRIED: f64 = 0.1;
/// Factor on the size of the random trials after a successful trial.
const LARGER: f64 = 1.5;
/// Factor on the size of the random trials after a failed trial. The size stays constant if one
/// trial in five succeeds.
const SMALLER: f64 = 0.9;

/// Free Fourier coefficients of a motion, and the quantities accumulated over one period of the
/// motion.
pub(super) struct Point {
    pub(super) x: DVector<f64>,
    pub(super) sweep: Sweep,
}

/// Searches for a maximum of the objective from a point inside the limits; `mu` is the weight of
/// the barrier at the limits. The search calls `go_on` before each of at most `steps` steps, and
/// ends if `go_on` returns false.
pub(super) fn search(
    objective: &mut Objective,
    from: Point,
    mu: f64,
    steps: usize,
    random: &mut Random,
    go_on: &mut dyn FnMut() -> bool,
) -> Point {
    let mut left = steps;
    let mut is_stopped = false;
    let mut now = from;
    while left > 0 && !is_stopped {
        let mut used = 0;
        now = ascend(objective, now, mu, left, &mut || {
            is_stopped |= !go_on();
            used += 1;
            !is_stopped
        });
        left = left.saturating_sub(used.max(1));
        let more = left.min(TRIALS_AS_STEPS);
        for _ in 0..more {
            is_stopped = is_stopped || !go_on();
        }
        if more > 0 && !is_stopped {
            now = try_at_random(objective, now, mu, random);
        }
        left -= more;
    }
    now
}

/// Evaluates random points near `from` and returns the best point found, or `from` if none is
/// better.
fn try_at_random(objective: &mut Objective, from: Point, mu: f64, random: &mut Random) -> Point {
    let mut now = from;
    let Some((mut value, _)) = objective.value(&now.x, mu) else { return now };
    let mut size = TRIED;
    for _ in 0..TRIALS {
        let scale = size * now.x.norm() / (now.x.len() as f64).sqrt();
        let x = &now.x + DVector::from_fn(now.x.len(), |_, _| scale * random.number());
        size *= match objective.value(&x, mu) {
            Some((better, sweep)) if better > value => {
                value = better;
                now = Point { x, sweep };
                LARGER
            }
            _ => SMALLER,
        };
    }
    now
}

/// Maximises the objective from a point inside the limits by a quasi-Newton method with at most
/// `steps` steps.
fn ascend(
    objective: &mut Objective,
    from: Point,
    mu: f64,
    steps: usize,
    go_on: &mut dyn FnMut() -> bool,
) -> Point {
    let mut now = from;
    let Some((mut value, _)) = objective.value(&now.x, mu) else { return now };
    let Some(mut gradient) = objective.gradient(&now.x, mu, &now.sweep) else { return now };
    let size = now.x.len();
    let mut inverse: Option<DMatrix<f64>> = None;
    let tolerance = SETTLED * objective.leaders.len() as f64;
    for _ in 0..steps {
        if !go_on() {
            break;
        }
        let mut direction = match &inverse {
            Some(inverse) => inverse * &gradient,
            None => &gradient * (FIRST * now.x.amax() / gradient.amax().max(1e-300)),
        };
        let mut slope = gradient.dot(&direction);
        if slope.is_nan() || slope <= 0.0 {
            inverse = None;
            direction = &gradient * (FIRST * now.x.amax() / gradient.amax().max(1e-300));
            slope = gradient.dot(&direction);
        }
        let mut length = 1.0;
        let mut found = None;
        for _ in 0..HALVINGS {
            let x = &now.x + &direction * length;
            if let Some((better, sweep)) = objective.value(&x, mu)
                && better >= value + SUFFICIENT * length * slope
            {
                found = Some((x, better, sweep));
                break;
            }
            length *= 0.5;
        }
        let Some((x, better, sweep)) = found else {
            // The search restarts once along the gradient. If that also fails, the point is a
            // maximum within the accuracy of finite differences.
            if inverse.take().is_some() {
                continue;
            }
            break;
        };
        let Some(next) = objective.gradient(&x, mu, &sweep) else {
            return Point { x, sweep };
        };
        let (step, change) = (&x - &now.x, &gradient - &next);
        let product = step.dot(&change);
        if product > 1e-12 * step.norm() * change.norm() {
            let mut h = inverse.take().unwrap_or_else(|| {
                DMatrix::identity(size, size) * (product / change.norm_squared())
            });
            // Update of the inverse Hessian H for the step s and the change y of the gradient:
            // H + (1 + y^T H y / s^T y) s s^T / s^T y - (H y s^T + s y^T H) / s^T y.
            let hy = &h * &change;
            let factor = (1.0 + change.dot(&hy) / product) / product;
            h.ger(factor, &step, &step, 1.0);
            h.ger(-1.0 / product, &hy, &step, 1.0);
            h.ger(-1.0 / product, &step, &hy, 1.0);
            inverse = Some(h);
        }
        let gain = better - value;
        (value, gradient) = (better, next);
        now = Point { x, sweep };
        if gain < tolerance {
            break;
        }
    }
    now
}
