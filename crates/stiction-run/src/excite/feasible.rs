//! Motions within the limits: the random motion from which the search starts, and the final check
//! between the samples of the search.

use super::ExciteError;
use super::ascent::Point;
use super::coordinates::Chosen;
use super::objective::{Grid, Objective, Sweep};
use super::probe::Probe;
use nalgebra::DVector;
use stiction_core::random::Random;

/// Size of the initial random motion, as a fraction of the largest size within all limits.
const START: f64 = 0.95;
/// Smallest factor on the initial random motion. If even this motion exceeds a limit, no motion
/// counts as feasible.
const LEAST: f64 = 1e-3;
/// Factor by which a motion is reduced if it exceeds a limit between the samples of the search.
const SHRINK: f64 = 0.99;
/// Largest number of times that a motion is reduced by [`SHRINK`].
const SHRINKS: usize = 100;

/// Returns an error if the robot has no finite forces, or exceeds a limit, while it rests at the
/// position where the motion begins.
pub(super) fn refuse_at_rest(probe: &mut Probe, chosen: &Chosen) -> Result<(), ExciteError> {
    let rest = vec![0.0; chosen.centre.len()];
    let Some(reading) = probe.at([&chosen.centre, &rest, &rest], None) else {
        return Err(ExciteError::no_answer(
            "no finite forces hold the robot at rest at the first position",
            "choose another motion with --motion; `stiction check` says what is singular",
        ));
    };
    let greatest: Vec<f64> = reading.parts.iter().map(|part| part.abs()).collect();
    let used = probe.limits.used(&greatest);
    let worst = used.iter().max_by(|a, b| a.part.total_cmp(&b.part));
    match worst {
        Some(worst) if worst.part >= 1.0 => Err(ExciteError::no_answer(
            format!(
                "no motion is feasible: at rest at the first position, {} is at {:.0} % of its limit of {:.4} {}",
                worst.name,
                100.0 * worst.part,
                worst.bound,
                worst.unit
            ),
            "widen the limit, or choose another first position with --motion",
        )),
        _ => Ok(()),
    }
}

/// Returns a random motion that is scaled so that it nearly reaches a limit.
pub(super) fn random_start(
    objective: &mut Objective,
    random: &mut Random,
    size: usize,
    chosen: &Chosen,
) -> Result<Point, ExciteError> {
    let count = size * chosen.centre.len();
    let x = DVector::from_fn(count, |_, _| random.number()) / (size as f64).sqrt();
    let feasible = |objective: &mut Objective, factor: f64| -> Option<Sweep> {
        let sweep = objective.sweep(&(&x * factor))?;
        sweep.greatest.iter().all(|part| *part < 1.0).then_some(sweep)
    };
    let mut high = 1.0;
    // Halving finds the order of magnitude of the largest factor; bisection then refines the
    // factor.
    while high >= LEAST && feasible(objective, high).is_none() {
        high *= 0.5;
    }
    if high < LEAST {
        let sweep = objective.sweep(&(&x * high));
        let why = sweep.and_then(|sweep| {
            let used = objective.used(&sweep);
            let worst = used.into_iter().max_by(|a, b| a.part.total_cmp(&b.part))?;
            Some(format!("{} reaches its limit of {:.4} {}", worst.name, worst.bound, worst.unit))
        });
        let why = why.unwrap_or_else(|| "the robot cannot follow".to_owned());
        return Err(ExciteError::no_answer(
            format!("no motion is feasible: even the smallest random motion fails, because {why}"),
            "widen the limits, lower --base-frequency, or choose another first position with \
             --motion",
        ));
    }
    let mut low = high;
    if high < 1.0 {
        high *= 2.0;
        for _ in 0..6 {
            let middle = 0.5 * (low + high);
            match feasible(objective, middle) {
                Some(_) => low = middle,
                None => high = middle,
            }
        }
    }
    resumed(objective, &(&x * (START * low)))
}

/// Evaluates one period of a motion that is known to satisfy the limits: information, used
/// fractions of the limits, efforts and barrier.
pub(super) fn resumed(objective: &mut Objective, x: &DVector<f64>) -> Result<Point, ExciteError> {
    let sweep = objective.sweep(x).ok_or_else(|| {
        ExciteError::no_answer(
            "the robot cannot follow the motion",
            "give another --seed or tighter limits",
        )
    })?;
    Ok(Point { x: x.clone(), sweep })
}

/// Scales a motion down until it also satisfies all limits on the finer time grid `fine`.
pub(super) fn held_between(
    objective: &mut Objective,
    fine: &Grid,
    mut x: DVector<f64>,
) -> Result<(DVector<f64>, Sweep), ExciteError> {
    for _ in 0..SHRINKS {
        if let Some(sweep) = objective.sweep_on(fine, &x)
            && sweep.greatest.iter().all(|part| *part <= 1.0)
        {
            return Ok((x, sweep));
        }
        x *= SHRINK;
    }
    Err(ExciteError::no_answer(
        "between the samples of the search, the designed motion exceeds its limits",
        "give another --seed or fewer harmonics",
    ))
}
