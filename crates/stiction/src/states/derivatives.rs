//! Derivatives of efforts with respect to coordinates, rates and accelerations.

use super::States;
use crate::error::Error;
use std::sync::Mutex;
use stiction_core::dynamics::{Data, FrictionMode, InverseDynamics};
use stiction_core::kinematics::Target;
use stiction_core::statics::AppliedLoad;
use stiction_program::{DerivativeMemory, DerivativeProgram, Quantity};

/// Derivatives of the efforts with respect to the state, exact to round-off. The derivatives
/// include the closure of the loops and the coupling of friction with its normal loads.
///
/// Each array has rows x actuators x coordinates, in N or N m per unit of the coordinate, rate or
/// acceleration. Each derivative is taken with the other coordinates, rates and accelerations of
/// the row constant. The derivatives are NaN in rows in which they do not exist.
#[derive(Clone, Debug, Default)]
pub struct Derivatives {
    /// Derivatives with respect to coordinates.
    pub by_position: Vec<f64>,
    /// Derivatives with respect to rates.
    pub by_rate: Vec<f64>,
    /// Derivatives with respect to accelerations; equal to the mass matrix if friction is off.
    pub by_acceleration: Vec<f64>,
    /// For each row, true if the derivatives exist. Efforts are not differentiable where a friction
    /// interface is at rest, because friction changes discontinuously with the direction of
    /// sliding.
    pub is_defined: Vec<bool>,
}

impl Derivatives {
    /// Combines the three arrays of derivatives. `rows` is the number of rows.
    pub(super) fn new(arrays: [Vec<f64>; 3], rows: usize) -> Self {
        let [by_position, by_rate, by_acceleration] = arrays;
        let width = by_position.len() / rows.max(1);
        let is_defined = (0..rows)
            .map(|row| by_position[row * width..][..width].iter().all(|slope| slope.is_finite()))
            .collect();
        Self { by_position, by_rate, by_acceleration, is_defined }
    }
}

/// Recorded program that computes the derivatives of the efforts of a robot.
#[derive(Debug)]
pub(super) struct Recorded {
    program: DerivativeProgram,
    /// Working memories of the program that no thread currently uses, each with a buffer for all
    /// derivatives at one state.
    spare: Mutex<Vec<(DerivativeMemory, Vec<f64>)>>,
}

/// Largest accepted difference between the efforts of the general solver and those of the program,
/// relative to the largest effort. The tolerance allows for rounding errors, which increase near
/// singular positions.
const SAME: f64 = 1e-6;

impl Recorded {
    /// Records the program for the derivatives at positions near the home position of the compiled
    /// robot.
    ///
    /// # Errors
    /// No program can be recorded for the friction mode or for the mechanism.
    pub(super) fn of(states: &States) -> Result<Self, Error> {
        let refuse = |reason: String| {
            Error::input(format!("no derivatives for `{}`: {reason}", states.robot.name()))
                .with_option("derivatives")
        };
        if states.home.is_empty() {
            return Err(refuse("it has no actuators".to_owned()));
        }
        let settings = states.prototype.settings;
        if settings.friction == FrictionMode::OnePass {
            return Err(refuse(
                "they exist only with converged friction or without friction".to_owned(),
            )
            .with_help("choose friction \"on\" or \"off\""));
        }
        let mechanism = match settings.friction {
            FrictionMode::Off => states.model.mechanism().without_friction(),
            _ => states.model.mechanism().clone(),
        };
        let at = |values: &[f64]| -> Vec<Target<f64>> {
            let at_rest = |&value: &f64| Target { value, rate: 0.0, acceleration: 0.0 };
            values.iter().map(at_rest).collect()
        };
        let home = at(&states.home);
        let solver = InverseDynamics::new(
            mechanism,
            &states.home_poses,
            states.model.constraints().coordinates(),
            &home,
            settings,
        )
        .map_err(|error| refuse(error.to_string()))?;
        let signal = positions(&solver, &states.home, states.coordinates.iter().map(|c| c.step));
        let quantities = quantities(states.home.len());
        DerivativeProgram::record(&solver, &signal, &states.loads, &quantities)
            .map(|program| Self { program, spare: Mutex::default() })
            .map_err(|error| refuse(error.to_string()))
    }

    /// Writes the derivatives with respect to coordinates, rates and accelerations at the state of
    /// `data` to `rows`, in this order. The efforts in `data` must have been computed at this
    /// state. `rows` remain unchanged if the efforts have no derivatives at this state.
    pub(super) fn write(
        &self,
        data: &Data<f64>,
        targets: &[Target<f64>],
        loads: &[AppliedLoad<f64>],
        rows: [&mut [f64]; 3],
    ) {
        // Does not wait for the lock: in a process forked while another thread held the lock, the
        // wait would never end.
        let spare = self.spare.try_lock().ok().and_then(|mut spare| spare.pop());
        let count = targets.len();
        let size = 3 * count * data.efforts().len();
        let (mut memory, mut slopes) =
            spare.unwrap_or_else(|| (self.program.memory(), vec![0.0; size]));
        if self.program.run(&mut memory, &data.state, targets, loads)
            && self.agrees(&memory, data.efforts())
        {
            self.program.jacobian(&mut memory, &mut slopes);
            if slopes.iter().all(|slope| slope.is_finite()) {
                for (kind, row) in rows.into_iter().enumerate() {
                    let all = slopes.chunks_exact(3 * count);
                    for (row, all) in row.chunks_exact_mut(count).zip(all) {
                        row.copy_from_slice(&all[kind * count..][..count]);
                    }
                }
            }
        }
        if let Ok(mut spare) = self.spare.try_lock() {
            spare.push((memory, slopes));
        }
    }

    /// True if the program computes the same efforts as the general solver, within [`SAME`].
    fn agrees(&self, memory: &DerivativeMemory, efforts: &[f64]) -> bool {
        let (inverse, forces) = (self.program.inverse(), self.program.forces(memory));
        let largest = efforts.iter().fold(f64::MIN_POSITIVE, |largest, x| largest.max(x.abs()));
        let mut each = efforts.iter().enumerate();
        each.all(|(k, effort)| (inverse.drive(forces, 0, k) - effort).abs() <= SAME * largest)
    }
}

/// Quantities with respect to which efforts are differentiated: all coordinates, then all rates,
/// then all accelerations.
fn quantities(count: usize) -> Vec<Quantity> {
    let each = [Quantity::Value, Quantity::Rate, Quantity::Acceleration];
    each.into_iter().flat_map(|of| (0..count).map(of)).collect()
}

/// Positions at which the program is recorded: the home position, and all positions at which one
/// coordinate differs from its home value by plus or minus one step. Positions at which the loops
/// cannot be closed are omitted.
fn positions(
    solver: &InverseDynamics,
    home: &[f64],
    steps: impl Iterator<Item = f64>,
) -> Vec<Vec<Target<f64>>> {
    let mut solver = solver.clone();
    let mut values = vec![home.to_vec()];
    for (k, step) in steps.enumerate() {
        for step in [step, -step] {
            let mut beside = home.to_vec();
            beside[k] += step;
            values.push(beside);
        }
    }
    let at_rest = |value: f64| Target { value, rate: 0.0, acceleration: 0.0 };
    let all = values.into_iter().map(|values| values.into_iter().map(at_rest).collect::<Vec<_>>());
    let all: Vec<_> = all.collect();
    let (first, others) = all.split_first().map_or((Vec::new(), &[][..]), |(f, o)| (f.clone(), o));
    let mut reachable = vec![first.clone()];
    for targets in others {
        if solver.move_to(targets).is_ok() {
            reachable.push(targets.clone());
        }
        if solver.move_to(&first).is_err() {
            break;
        }
    }
    reachable
}
