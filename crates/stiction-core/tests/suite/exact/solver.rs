//! Builds the library's solver from a drawing.

use super::Drawing;
use crate::common::random::Random;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Pose;

/// Assembles the mechanism in its drawn configuration with the pose of every body prescribed.
/// Prescribing less would not test more, and this leaves no DOF undetermined.
pub fn assembled(drawing: &Drawing, random: &mut Random) -> InverseDynamics {
    let scale = random.pick(&[1.0, 1.0, 0.1, 1e-3, 1e3]);
    let turned = random.below(2) == 0;
    let frames: Vec<Pose<f64>> = drawing
        .coms
        .iter()
        .map(|_| match turned {
            true => Pose { position: random.vector() * scale, ..random.pose(0.0) },
            false => Pose::identity(),
        })
        .collect();
    let mechanism = drawing.build(&frames, scale);
    let (mut coordinates, mut targets) = (Vec::new(), Vec::new());
    for (index, frame) in frames.iter().enumerate() {
        let body = BodyId(index + 1);
        for axis in 0..3 {
            let turn = frame.rotation.rotation_vector().component(axis);
            coordinates.push(Coordinate::Position { body, axis });
            targets.push(frame.position.component(axis));
            coordinates.push(Coordinate::RotationVector { body, axis });
            targets.push(turn);
        }
    }
    let targets: Vec<_> =
        targets.into_iter().map(|value| Target { value, rate: 0.0, acceleration: 0.0 }).collect();
    let initial_poses: Vec<_> =
        frames.iter().enumerate().map(|(k, f)| (BodyId(k + 1), *f)).collect();
    InverseDynamics::new(mechanism, &initial_poses, &coordinates, &targets, Settings::default())
        .unwrap_or_else(|error| panic!("{error} {drawing:?}"))
}
