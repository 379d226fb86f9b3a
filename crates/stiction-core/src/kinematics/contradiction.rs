//! Checks prescribed rates and accelerations against the loop constraints.
//!
//! If there are more constraint equations than degrees of freedom, the solution for the rates omits
//! dependent equations. Along a feasible motion, the omitted equations hold automatically. At an
//! isolated configuration they may be violated: the loops close there, but the prescribed rates
//! would open them.

use super::coordinate::Target;
use super::model::KinematicModel;
use super::motion_constraints::MotionConstraints;
use super::system::Kinematics;
use super::{AssemblyError, State};
use crate::parameters::Parameters;

/// Relative tolerance of a constraint equation, as a fraction of the sum of the magnitudes of its
/// terms. It exceeds the inconsistency of interpolated recordings of redundant coordinates.
const RELATIVE: f64 = 1e-5;
/// Absolute tolerance of a constraint equation, 1/s and 1/s², with lengths in characteristic
/// lengths. It is below the rates of any practical motion and above the round-off of rates at a
/// reversal.
const ABSOLUTE: f64 = 1e-9;

/// A violated constraint equation: its row, and the magnitude `by` of its residual. The unit of the
/// residual is m/s or rad/s for rates, and m/s² or rad/s² for accelerations.
#[derive(Clone, Copy, Default)]
struct Missed {
    row: usize,
    by: f64,
    /// Magnitude of the residual, with lengths divided by the characteristic length.
    size: f64,
}

impl Kinematics<f64> {
    /// Returns an error if rates or accelerations violate a loop constraint or a prescribed
    /// coordinate. The rates and accelerations must be those of the last [`Self::differentiate`].
    pub(super) fn contradiction(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<f64>,
        state: &State<f64>,
        targets: &[Target<f64>],
        joint_names: &[String],
    ) -> Result<(), AssemblyError> {
        let (topology, motion_constraints) = (model.topology(), model.constraints());
        let Some((missed, order)) = self.most_missed(model, parameters, state, targets) else {
            return Ok(());
        };
        let is_angle = motion_constraints.are_angles().nth(missed.row).unwrap_or(false);
        let unit = match (is_angle, order) {
            (true, "rates") => "rad/s",
            (false, "rates") => "m/s",
            (true, _) => "rad/s^2",
            (false, _) => "m/s^2",
        };
        let loops = topology.cuts.iter().flat_map(|cut| {
            topology.joint_types[cut.joint].constraints().iter().map(|_| cut.joint)
        });
        // In `joint_names`, the names of the gearings follow those of the joints.
        let gearings = topology.gearings.iter().map(|own| topology.joint_types.len() + own.gearing);
        let joint = loops.chain(gearings).nth(missed.row).map(|joint| joint_names[joint].clone());
        let of_gearing = missed.row >= topology.constraints;
        Err(AssemblyError::Contradiction { order, joint, of_gearing, by: missed.by, unit })
    }

    /// Returns `true` if rates or accelerations violate a loop constraint or a prescribed
    /// coordinate. The rates and accelerations must be those of the last [`Self::differentiate`].
    /// Does not allocate.
    pub(crate) fn contradicts(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<f64>,
        state: &State<f64>,
        targets: &[Target<f64>],
    ) -> bool {
        self.most_missed(model, parameters, state, targets).is_some()
    }

    /// Finds the constraint equation that the rates violate most. If the rates violate none, finds
    /// the equation that the accelerations violate most.
    fn most_missed(
        &mut self,
        model: &KinematicModel,
        parameters: &Parameters<f64>,
        state: &State<f64>,
        targets: &[Target<f64>],
    ) -> Option<(Missed, &'static str)> {
        let (topology, motion_constraints) = (model.topology(), model.constraints());
        if motion_constraints.row_count() <= topology.dofs() {
            return None;
        }
        self.right_of_rates(motion_constraints, targets);
        let rates = self.missed(motion_constraints, &state.rates, parameters.length);
        self.right_of_accelerations(topology, parameters, motion_constraints, targets);
        let accelerations =
            self.missed(motion_constraints, &state.accelerations, parameters.length);
        match (rates, accelerations) {
            (Some(rates), _) => Some((rates, "rates")),
            (None, Some(accelerations)) => Some((accelerations, "accelerations")),
            (None, None) => None,
        }
    }

    /// Finds the constraint equation whose residual exceeds the tolerances most. `found` contains
    /// the rates or the accelerations of the spanning tree.
    fn missed(
        &self,
        motion_constraints: &MotionConstraints,
        found: &[f64],
        length: f64,
    ) -> Option<Missed> {
        let mut worst = Missed::default();
        let mut entries = motion_constraints.entries().iter().zip(self.entries.iter()).peekable();
        for (row, (is_angle, right)) in
            motion_constraints.are_angles().zip(self.right_hand_side()).enumerate()
        {
            let (mut sum, mut terms) = (-right, right.abs());
            while let Some((entry, value)) = entries.next_if(|(entry, _)| entry.row == row) {
                let term = value * found[entry.column];
                sum += term;
                terms += term.abs();
            }
            let size = sum.abs() * if is_angle { 1.0 } else { length.recip() };
            if sum.abs() > RELATIVE * terms && size > ABSOLUTE && size > worst.size {
                worst = Missed { row, by: sum.abs(), size };
            }
        }
        (worst.size > 0.0).then_some(worst)
    }
}
