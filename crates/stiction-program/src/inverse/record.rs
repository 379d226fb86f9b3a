//! Recording, compilation and verification of programs of inverse dynamics.

use super::{DerivativeCode, InverseProgram, Places};
use crate::code::{Part, Slots, compile};
use crate::compiled::Compiled;
use crate::error::RecordError;
use crate::graph::{Node, Op, needed};
use crate::inverse_stages::InverseStages;
use crate::loaded::{LoadPlace, place_of};
use crate::machine::fuses;
use crate::program_inputs::InputLayout;
use crate::quantity::Quantity;
use crate::recording::{Counts, RecordingSource};
use crate::run::{Runner, natural_lanes};
use crate::samples::{Sample, StateRange, samples, seeded_samples};
use crate::stages::{early, passed_on};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics};
use stiction_core::kinematics::Target;

/// Largest accepted difference between the forces of program and solver, relative to the largest
/// joint force. This limit allows for rounding errors, which are magnified at ill-conditioned
/// samples near singular positions.
const AGREES: f64 = 1e-9;

impl InverseProgram {
    /// Records and compiles the program of a mechanism.
    ///
    /// `signal` contains prescribed values within the intended range of motion, each close enough
    /// to the previous one for the solver to follow. The solver starts from its present position.
    /// `loads` defines the loaded bodies, points and axes; the wrenches themselves are inputs.
    /// Friction is that of the mechanism, coupled with the reactions, independently of the solver's
    /// settings.
    ///
    /// # Errors
    /// See [`RecordError`]: the solver has no fixed order of elimination for the mechanism (at a
    /// singular position), the solver cannot follow the signal, or the program does not reproduce
    /// the solver's forces.
    pub fn record(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
    ) -> Result<Self, RecordError> {
        Self::record_with(solver, signal, loads, true)
    }

    /// Records and compiles a program as [`Self::record`] does. If `machine` is false, the program
    /// is interpreted, which is slow and intended for tests of the machine code.
    #[doc(hidden)]
    pub fn record_with(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
        machine: bool,
    ) -> Result<Self, RecordError> {
        let made = Self::record_with_derivatives(solver, signal, loads, &[], machine)?;
        Ok(made.0)
    }

    /// Records and compiles a program as [`Self::record_with`] does, together with code for the
    /// derivatives of all actuator forces with respect to `quantities`, at the last evaluated
    /// state.
    pub(crate) fn record_with_derivatives(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
        quantities: &[Quantity],
        machine: bool,
    ) -> Result<(Self, DerivativeCode), RecordError> {
        let model = solver.model().map_err(|_| RecordError::NoPlan)?;
        let samples = samples(solver, signal, loads)?;
        let positions: Vec<Vec<f64>> =
            samples.iter().map(|sample| sample.state.coordinates.clone()).collect();
        let layout = InputLayout::new(solver, &positions, loads.len());
        let samples: Vec<Vec<f64>> = samples.iter().map(|sample| layout.row(sample)).collect();
        let source = RecordingSource { model: &model, solver, loads };
        let recorded = source.record_inverse(&layout, &samples, quantities)?;
        let places = loads.iter().map(place_of).collect();
        let made = Self::compile(source.counts(0), &recorded, layout, places, machine)?;
        let others = seeded_samples(9, StateRange::Usual, solver, signal, loads)?;
        if made.0.agrees_with(solver, &others) { Ok(made) } else { Err(RecordError::NotConfirmed) }
    }

    /// Returns `true` if the forces of the program agree with those of its solver at `samples`,
    /// which must differ from the samples of the recording. Samples at which the program or the
    /// solver computes no forces are skipped.
    fn agrees_with(&self, solver: &InverseDynamics, samples: &[Sample]) -> bool {
        let mut solver = solver.clone();
        solver.settings_mut().friction = FrictionMode::Converged;
        let length = solver.mechanism().characteristic_length();
        let mut memory = self.memory(1);
        let mut settled = [false];
        samples.iter().all(|Sample { state, targets, loads, .. }| {
            self.set(&mut memory, 0, state, targets, loads);
            self.run(&mut memory, &mut settled);
            if !settled[0] || solver.move_to(targets).is_err() {
                return true;
            }
            let Ok(forces) = solver.solve(loads) else { return true };
            let largest = forces.reactions.iter().map(|(force, _)| force.norm());
            let largest = largest.fold(f64::MIN_POSITIVE, f64::max);
            let same = |found: f64, expected: f64, unit: f64| {
                (found - expected).abs() <= AGREES * largest * unit
            };
            let drives = forces.efforts.iter().enumerate();
            let mut drives = drives.map(|(k, drive)| (self.drive(&memory, 0, k), *drive));
            let reactions = forces.reactions.iter().enumerate();
            let mut reactions = reactions.flat_map(|(joint, (force, moment))| {
                let expected = [force.to_array(), moment.to_array().map(|m| m / length)];
                let mut found = self.reaction(&memory, 0, joint);
                found[3..].iter_mut().for_each(|moment| *moment /= length);
                found.into_iter().zip(expected.into_iter().flatten())
            });
            drives.all(|(found, expected)| same(found, expected, length.max(1.0)))
                && reactions.all(|(found, expected)| same(found, expected, 1.0))
        })
    }

    fn compile(
        counts: Counts,
        recorded: &InverseStages,
        layout: InputLayout,
        loaded: Vec<LoadPlace>,
        machine: bool,
    ) -> Result<(Self, DerivativeCode), RecordError> {
        let ops = recorded.graph.ops();
        let fuse = machine && fuses();
        let inputs = layout.count();
        let mut slots = Slots::of_inputs(ops, 0..recorded.slope_inputs.start);
        let with = |nodes: &[Node], guard: Node| [nodes, &[guard]].concat();
        let ideal = with(&recorded.ideal, recorded.guards[0]);
        let last = with(&recorded.rest, recorded.guards[1]);
        let step = [&recorded.next[..], &recorded.control].concat();
        let prescribed = layout.first_prescribed() as u32..layout.count() as u32;
        let reads = |(op, needed): (&Op, bool)| matches!(op, Op::Input(place) if needed && prescribed.contains(place));
        let all = [&ideal[..], &recorded.begin, &step, &last, &recorded.slopes].concat();
        let reads_targets = ops.iter().zip(needed(ops, &all)).any(reads);
        let mut stages = [const { Vec::new() }; 4];
        // The frictionless stage has its own slots, which no other stage reads.
        let mut own = slots.clone();
        stages[0] = compile(ops, &ideal, &mut own, fuse);
        let (ideal, ideal_guard) = (own.places(&recorded.ideal)?, own.place(recorded.guards[0])?);
        let (ideal_drives, ideal_reactions) = ideal.split_at(counts.drives);
        slots.reserve(own.count() - slots.count());
        // Each stage computes its own results, and those values needed by later stages that do not
        // depend on the inputs of the later stages.
        let is_late = |input| input >= inputs;
        let shared = early(ops, &recorded.slopes, |input| recorded.slope_inputs.contains(&input));
        let prepared = match recorded.slopes[..] {
            [] => Vec::new(),
            _ => with(&shared, recorded.guards[2]),
        };
        let mut first = early(ops, &[&step[..], &last, &prepared].concat(), is_late);
        first.extend(&recorded.begin);
        stages[1] = compile(ops, &first, &mut slots, fuse);
        let second = [&step[..], &passed_on(ops, &step, &last, is_late)].concat();
        stages[2] = compile(ops, &second, &mut slots, fuse);
        stages[3] = compile(ops, &last, &mut slots, fuse);
        let preparation = compile(ops, &prepared, &mut slots, fuse);
        let mut wide = Slots::of_inputs(ops, recorded.slope_inputs.clone());
        for node in shared {
            wide.assign_common(node, slots.place(node)?);
        }
        let directions = compile(ops, &recorded.slopes, &mut wide, fuse);
        let [change, size, determinant] = recorded.control;
        let rest = slots.places(&recorded.rest)?;
        let mut rest = rest.as_slice();
        let mut take = |count: usize| {
            let (front, back) = rest.split_at(count);
            rest = back;
            front.to_vec()
        };
        let places = Places {
            from: recorded.from.clone(),
            start: slots.places(&recorded.begin)?,
            next: slots.places(&recorded.next)?,
            control: [slots.place(change)?, slots.place(size)?, slots.place(determinant)?],
            ideal_guard,
            guard: slots.place(recorded.guards[1])?,
            ideal_drives: ideal_drives.to_vec(),
            ideal_reactions: ideal_reactions.to_vec(),
            drives: take(counts.drives),
            reactions: take(6 * counts.joints),
            loads: take(counts.interfaces),
            velocities: take(counts.interfaces),
            frictions: take(counts.interfaces),
        };
        let code = Compiled::new(stages, slots.count(), machine);
        let operations = |parts: &[Part]| parts.iter().map(Part::operations).sum();
        let derivatives = DerivativeCode {
            operations: [operations(&preparation), operations(&directions)],
            preparation: Runner::new(&preparation, 1, slots.count(), machine),
            directions: Runner::new(&directions, natural_lanes(), wide.count(), machine),
            slots: wide.count(),
            slopes: wide.places(&recorded.slopes)?,
            // Nothing is prepared if no derivatives are requested.
            guard: if prepared.is_empty() { 0 } else { slots.place(recorded.guards[2])? },
            reactions: recorded.reactions.clone(),
        };
        Ok((Self { layout, loaded, reads_targets, counts, places, code }, derivatives))
    }
}
