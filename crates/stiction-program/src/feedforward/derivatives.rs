//! Recording of the derivatives of actuator forces for generated source code.

use super::record::{loads_of, rows, there_and_back};
use super::{Feedforward, Routine};
use crate::code::{Slots, compile};
use crate::error::RecordError;
use crate::inverse_stages::InverseStages;
use crate::program_inputs::InputLayout;
use crate::quantity::Quantity;
use crate::recording::RecordingSource;
use crate::samples::{StateRange, seeded_samples};
use crate::stages::early;
use crate::tunable::Tunable;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::kinematics::Target;

/// Routines that compute the derivatives of all actuator forces with respect to the values, rates
/// and accelerations of the prescribed coordinates. These routines have slots of their own.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    /// Two routines: the preparation at a state, and the slopes of the actuator forces along a
    /// direction. The first routine returns a guard, which is positive while the assumptions made
    /// at recording hold; the second returns one slope for each actuator.
    pub(crate) routines: [Routine; 2],
    /// Indices of the joints with friction interfaces. The wrenches of these joints are inputs.
    pub(crate) joints: Vec<usize>,
    /// Slots of the inputs, in this order: tree coordinates; tunable parameters; value, rate and
    /// acceleration of each prescribed coordinate; wrenches of the joints with friction interfaces;
    /// components of the direction, first for all values, then for all rates, then for all
    /// accelerations.
    pub(crate) inputs: Vec<u32>,
}

impl Feedforward {
    /// Adds derivatives to the program, for generated source code. `solver` and `signal` must be
    /// those that were passed to [`Self::record`].
    ///
    /// # Errors
    /// See [`RecordError`].
    pub fn with_derivatives(
        mut self,
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
    ) -> Result<Self, RecordError> {
        let mut solver = solver.clone();
        let home = signal.first().ok_or(RecordError::EmptySignal)?;
        solver.move_to(home).map_err(|error| RecordError::Signal { position: 0, error })?;
        let model = solver.model().map_err(|_| RecordError::NoPlan)?;
        let tunables: Vec<Tunable> = self.tunables.iter().map(|(tunable, _)| *tunable).collect();
        let loads = loads_of(&tunables);
        let source = RecordingSource { model: &model, solver: &solver, loads: &loads };
        let layout = InputLayout::of_tree(&solver, &tunables);
        let all = seeded_samples(1, StateRange::Wide, &solver, &there_and_back(signal), &[])?;
        let count = self.sizes.prescribed;
        let kinds: [fn(usize) -> Quantity; 3] =
            [Quantity::Value, Quantity::Rate, Quantity::Acceleration];
        let quantities: Vec<Quantity> =
            kinds.iter().flat_map(|kind| (0..count).map(kind)).collect();
        let rows = rows(&solver, &all, &tunables);
        let stages = source.record_inverse(&layout, &rows, &quantities)?;
        self.derivatives = Some(Derivatives::compile(&stages, layout.count())?);
        Ok(self)
    }
}

impl Derivatives {
    fn compile(stages: &InverseStages, given: usize) -> Result<Self, RecordError> {
        let InverseStages { graph, slopes, slope_inputs, reactions, guards, .. } = stages;
        let ops = graph.ops();
        let mut slots = Slots::of_inputs(ops, 0..slope_inputs.end);
        let mut prepared = early(ops, slopes, |input| slope_inputs.contains(&input));
        prepared.push(guards[2]);
        let parts = compile(ops, &prepared, &mut slots, false);
        let preparation = Routine { parts, results: slots.places(&[guards[2]])? };
        let parts = compile(ops, slopes, &mut slots, false);
        let directions = Routine { parts, results: slots.places(slopes)? };
        let of_reactions = reactions.iter().flat_map(|(_, first)| *first..*first + 6);
        let inputs = (0..given).chain(of_reactions).chain(slope_inputs.clone());
        Ok(Self {
            routines: [preparation, directions],
            joints: reactions.iter().map(|(joint, _)| *joint).collect(),
            inputs: inputs.map(|input| input as u32).collect(),
        })
    }
}
