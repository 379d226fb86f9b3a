//! Right-hand sides of the system for rates and for accelerations.

use super::{Kinematics, reference_orientation};
use crate::kinematics::coordinate::{Coordinate, Target};
use crate::kinematics::measure;
use crate::kinematics::motion_constraints::MotionConstraints;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::topology::Topology;

impl<T: Scalar> Kinematics<T> {
    /// Sets the right-hand side for the rates of the spanning tree: zero for loops, gearings and
    /// passive spins, and the prescribed rates for the prescribed coordinates.
    pub(in crate::kinematics) fn right_of_rates(
        &mut self,
        motion_constraints: &MotionConstraints,
        targets: &[Target<T>],
    ) {
        let closures = self.closures;
        self.right.fill(T::zero());
        let coordinates =
            motion_constraints.coordinates.iter().zip(&motion_constraints.orientations);
        let coordinates = coordinates.zip(targets);
        for (right, ((&coordinate, &orientation), target)) in
            self.right[closures..].iter_mut().zip(coordinates)
        {
            *right = match (coordinate, orientation) {
                (Coordinate::RotationVector { axis, .. }, Some(places)) => {
                    reference_orientation(targets, places).rate.component(axis)
                }
                _ => target.rate,
            };
        }
    }

    /// Returns the right-hand side of the system as last set, one value for each row.
    pub(in crate::kinematics) fn right_hand_side(&self) -> &[T] {
        &self.right
    }

    /// Sets the right-hand side for the accelerations of the spanning tree: prescribed
    /// accelerations (zero for loops, gearings and passive spins), minus the velocity terms of the
    /// second derivatives.
    pub(in crate::kinematics) fn right_of_accelerations(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
        targets: &[Target<T>],
    ) {
        let mut row = 0;
        for cut in &topology.cuts {
            let (predecessor, successor) = topology.ends[cut.joint];
            let bias = &self.bodies.bias;
            let own = self.bodies.joint_bias(topology, parameters, cut.joint);
            let open = bias[successor] - bias[predecessor] - own;
            for _ in topology.joint_types[cut.joint].constraints() {
                self.right[row] = -open.power(self.covectors[row]);
                row += 1;
            }
        }
        for _ in &topology.gearings {
            self.right[row] = T::zero();
            row += 1;
        }
        let coordinates =
            motion_constraints.coordinates.iter().zip(&motion_constraints.orientations);
        let mut angles = None;
        for ((&coordinate, &orientation), target) in coordinates.zip(targets) {
            let covector = self.covectors[row];
            self.right[row] = match (coordinate, orientation) {
                (Coordinate::RotationVector { body, axis }, Some(places)) => {
                    reference_orientation(targets, places).acceleration.component(axis)
                        - self.bodies.bias[body.0].power(covector)
                }
                _ => {
                    let at = (&self.bodies, &mut angles);
                    target.acceleration
                        - measure::bias(coordinate, topology, parameters, at, covector)
                }
            };
            row += 1;
        }
        for spin in &motion_constraints.spins {
            self.right[row] = -self.bodies.bias[spin.body.0].power(self.covectors[row]);
            row += 1;
        }
    }

    /// Computes the velocity terms of the second derivatives of the loop errors, one for each
    /// equation of loops and gearings. The twists of the bodies must be up to date.
    pub(in crate::kinematics) fn closure_biases(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        motion_constraints: &MotionConstraints,
    ) -> Vec<T> {
        self.right_of_accelerations(topology, parameters, motion_constraints, &[]);
        self.right[..self.closures].iter().map(|right| -*right).collect()
    }
}
