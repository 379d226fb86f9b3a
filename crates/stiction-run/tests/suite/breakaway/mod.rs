//! Static friction: intervals, breakaway and self-locking against closed forms and against all
//! combinations of friction forces.

mod begins;
mod closed_forms;
mod holder;
mod many_interfaces;
mod ways_to_hold;

use crate::common::*;
use stiction_core::dynamics::FrictionMode;
use stiction_run::breakaway::{Findings, evaluate};

/// Computes the results for a model at the start of its default motion under its default load.
fn at_rest(text: &str) -> Findings {
    let model = model_of("rest", text);
    evaluate(&default_job(&model, FrictionMode::Converged), None).unwrap()
}

fn near(found: f64, expected: f64) {
    // Closed forms and the kernel differ only by rounding errors.
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-3), "{found} {expected}");
}
