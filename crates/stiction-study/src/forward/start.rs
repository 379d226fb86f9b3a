//! Where a simulation starts.

use super::job::{Job, Start};
use super::run::Error;
use stiction::forward::{Forward, ForwardError};
use stiction::kinematics::{AssemblyError, Coordinate, State, Target};
use stiction::mechanism::JointId;
use stiction_model::Motion;

/// The tree's coordinates and rates at the start.
pub(super) fn state(job: &Job<'_>, forward: &Forward) -> Result<State<f64>, Error> {
    let (motion, moves) = match job.start {
        Start::Moving => (job.motion, true),
        Start::AtRest => (job.motion, false),
        Start::Given(motion) => (Some(motion), true),
        Start::Home => (None, false),
    };
    let mut coordinates = Vec::new();
    let mut targets = Vec::new();
    if let Some(motion) = motion {
        check(motion)?;
        for ((coordinate, _), target) in motion.coordinates.iter().zip(motion.at(motion.start)) {
            let rate = if moves { target.rate } else { 0.0 };
            coordinates.push(*coordinate);
            targets.push(Target { rate, ..target });
        }
    }
    complete(job, forward, coordinates, targets)
}

/// A formula without a finite value starts nothing.
fn check(motion: &Motion) -> Result<(), Error> {
    for (_, course) in &motion.coordinates {
        if let Some(fault) = course.fault_at(motion.start) {
            return Err(Error::Motion(crate::inverse::Error::NotFinite(Box::new(fault))));
        }
    }
    Ok(())
}

/// Assembles at what is given; freedoms that it leaves open are taken from the model's own start, joint by
/// joint, actuated ones first.
fn complete(
    job: &Job<'_>,
    forward: &Forward,
    mut coordinates: Vec<Coordinate>,
    mut targets: Vec<Target<f64>>,
) -> Result<State<f64>, Error> {
    let homes = &job.model.homes;
    let attempt = |coordinates: &[Coordinate], targets: &[Target<f64>]| {
        forward.assemble(homes, coordinates, targets)
    };
    let first = match attempt(&coordinates, &targets) {
        Ok(state) => return Ok(state),
        Err(error) => error,
    };
    let ForwardError::Assembly(AssemblyError::Open { open }) = &first else {
        return Err(Error::Forward(first));
    };
    let mut left = open.len();
    for (coordinate, value) in candidates(forward) {
        if coordinates.contains(&coordinate) {
            continue;
        }
        coordinates.push(coordinate);
        targets.push(Target { value, rate: 0.0, acceleration: 0.0 });
        match attempt(&coordinates, &targets) {
            Ok(state) => return Ok(state),
            Err(ForwardError::Assembly(AssemblyError::Open { open })) if open.len() < left => {
                left = open.len();
            }
            Err(_) => {
                coordinates.pop();
                targets.pop();
            }
        }
    }
    Err(Error::Forward(first))
}

/// The scalar coordinates of all joints with their start values, actuated ones first.
fn candidates(forward: &Forward) -> Vec<(Coordinate, f64)> {
    let joints = forward.mechanism().joints();
    let mut all = Vec::new();
    for actuated in [true, false] {
        for (index, joint) in joints.iter().enumerate() {
            if !joint.joint_type.has_scalar_coordinates() {
                continue;
            }
            for (freedom, (driven, value)) in joint.actuated.iter().zip(&joint.start).enumerate() {
                if *driven == actuated {
                    all.push((Coordinate::Joint { joint: JointId(index), freedom }, *value));
                }
            }
        }
    }
    all
}
