//! Friction laws and normal-load maps against closed forms.

mod curves;
mod guides;
mod screws;
mod surfaces;

use crate::common::*;
use stiction_core::dynamics::FrictionMode;
use stiction_run::Error;

const G: f64 = 9.81;

pub(crate) fn run(text: &str) -> Result<Run, Error> {
    let model = model_of("closed form", text);
    Run::of(&default_job(&model, FrictionMode::Converged))
}

/// Returns the text of a model with one motion, without load and with gravity downwards.
pub(crate) fn model(parts: &str, motion: &str) -> String {
    format!(
        r#"
        gravity = [0, 0, "-{G} m/s^2"]
        {parts}
        [motions.m]
        duration = "0.1 s"
        step = "0.05 s"
        {motion}
        [loads.none]
        [default]
        motion = "m"
        load = "none"
        "#
    )
}

pub(crate) fn body(name: &str, mass: f64) -> String {
    format!("[bodies.{name}]\nmass = {mass:?}\ncom = [0, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n")
}
