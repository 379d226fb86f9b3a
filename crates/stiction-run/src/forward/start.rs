//! Initial states of simulations.

use super::job::{Job, Start};
use crate::error::{Error, check_finite};
use stiction_core::forward::{Forward, ForwardError, Known};
use stiction_core::kinematics::{AssemblyError, Coordinate, State, Target};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Vec3;

/// Computes the initial coordinates and rates of the spanning tree. Also returns notes for the user
/// on the assembly.
pub(super) fn state(job: &Job<'_>, forward: &Forward) -> Result<(State<f64>, Vec<String>), Error> {
    let (motion, moves) = match job.start {
        Start::Moving => (job.motion, true),
        Start::AtRest => (job.motion, false),
        Start::Given(motion) => (Some(motion), true),
        Start::Known(_) | Start::Home => (None, false),
    };
    let initial_poses = &job.model.initial_poses;
    if let Start::Known(known) = job.start {
        let known = angular(known.to_vec());
        let state = forward.assemble_from(initial_poses, &known).map_err(Error::Forward)?;
        return Ok((state, Vec::new()));
    }
    let (mut coordinates, mut targets) = (Vec::new(), Vec::new());
    if let Some(motion) = motion {
        check_finite(motion.signals(), motion.start)?;
        for ((coordinate, _), target) in motion.coordinates.iter().zip(motion.at(motion.start)) {
            let rate = if moves { target.rate } else { 0.0 };
            coordinates.push(*coordinate);
            targets.push(Target { rate, ..target });
        }
        match forward.assemble_with_report(initial_poses, &coordinates, &targets) {
            // The motion does not determine the configuration, or the configuration is singular.
            // The assembly below determines the remaining coordinates.
            Err(ForwardError::Assembly(error))
                if !matches!(error, AssemblyError::AngleRange { .. }) => {}
            other => {
                let (state, report) = other.map_err(Error::Forward)?;
                return Ok((state, report.notes()));
            }
        }
    }
    let each = coordinates.iter().zip(&targets);
    let known: Vec<Known> = each
        .map(|(&coordinate, target)| {
            let (value, rate) = (Some(target.value), Some(target.rate));
            Known { coordinate, value, rate }
        })
        .collect();
    let known = angular(known);
    let state = forward.assemble_from(initial_poses, &known).map_err(Error::Forward)?;
    Ok((state, Vec::new()))
}

/// Converts the rates of a rotation vector `v` to an angular velocity: `omega = (1 + (1 - cos a)/a^2 [v] + (a - sin
/// a)/a^3 [v]^2) dv/dt` with `a = |v|`, where `[v]` is the cross-product matrix.
fn angular(mut known: Vec<Known>) -> Vec<Known> {
    let place = |known: &[Known], of: BodyId, axis: usize| {
        let is = |k: &Known| k.coordinate == Coordinate::RotationVector { body: of, axis };
        known.iter().position(is)
    };
    for first in 0..known.len() {
        let Coordinate::RotationVector { body, axis: 0 } = known[first].coordinate else {
            continue;
        };
        let (Some(second), Some(third)) = (place(&known, body, 1), place(&known, body, 2)) else {
            continue;
        };
        let places = [first, second, third];
        let vector = |of: fn(&Known) -> Option<f64>| {
            let [x, y, z] = places.map(|k| of(&known[k]).unwrap_or(0.0));
            Vec3::new(x, y, z)
        };
        let (turned, rate) = (vector(|k| k.value), vector(|k| k.rate));
        let angle = turned.norm();
        let across = turned.cross(rate);
        // The half angle avoids cancellation at small angles.
        let half = (0.5 * angle).sin();
        let (once, twice) = if angle < 1e-4 {
            (0.5, 1.0 / 6.0)
        } else {
            (2.0 * half * half / angle.powi(2), (angle - angle.sin()) / angle.powi(3))
        };
        let omega = rate + across * once + turned.cross(across) * twice;
        for (k, rate) in places.into_iter().zip(omega.to_array()) {
            known[k].rate = Some(rate);
        }
    }
    known
}
