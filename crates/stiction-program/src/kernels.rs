//! Program that replaces the kernels of inverse dynamics along a motion: motion of all bodies,
//! forces without friction, and responses to unit friction forces.
//!
//! The driver of `stiction-core` finds the friction forces from these results and verifies them
//! like those of the kernels.

use crate::code::{Code, Part, Slots, Source, compile};
use crate::error::RecordError;
use crate::graph::{Graph, Node};
use crate::machine::{fuses, instructions};
use crate::program_inputs::{load_to_array, target_to_array};
use crate::recorded::{Recorded, record_groups};
use crate::recording::RecordingSource;
use crate::run::Runner;
use crate::samples::{Sample, samples};
use crate::stages::{holds, passed_on};
use crate::value_numbering::{Merged, merge};
use core::ops::Range;
use std::sync::Arc;
use stiction_core::dynamics::{
    AppliedLoad, FrictionMode, InverseDynamics, Settings, force_results, motion_results,
};
use stiction_core::kinematics::{KernelProgram, ProgramMemory, Stage, Target};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;

/// Compiled program of the kernels for one mechanism.
#[derive(Debug)]
pub struct RecordedKernels {
    stages: [RecordedStage; 2],
    slots: usize,
    scratch: usize,
}

/// Code of one stage, and the slots of its results.
#[derive(Debug)]
struct RecordedStage {
    code: Runner,
    results: Range<usize>,
    /// Slot of the guard, which is positive while the assumptions made at recording hold.
    guard: u32,
    operations: usize,
}

impl RecordedKernels {
    /// Records and compiles the program of a mechanism.
    ///
    /// `signal` contains prescribed values within the intended range of motion, each close enough
    /// to the previous one for the solver to follow. The solver starts from its present position.
    /// `loads` defines the loaded bodies, points and axes; the wrenches themselves are inputs.
    ///
    /// # Errors
    /// [`RecordError::NotNative`] if the program would have to be interpreted, which is slower than
    /// the kernels; [`RecordError::Redundant`] if constraints are redundant or bodies have local
    /// degrees of freedom; [`RecordError::Signal`].
    pub fn record(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
    ) -> Result<Arc<Self>, RecordError> {
        if instructions().is_none() {
            return Err(RecordError::NotNative);
        }
        if !solver.admits_program() {
            return Err(RecordError::Redundant);
        }
        let model = solver.model().map_err(|_| RecordError::NoPlan)?;
        let source = RecordingSource { model: &model, solver, loads };
        let inputs = |Sample { state, targets, loads, .. }: Sample| -> Vec<f64> {
            let mut all = state.coordinates;
            all.extend(targets.iter().flat_map(target_to_array));
            all.extend(loads.iter().flat_map(load_to_array));
            all
        };
        let samples: Vec<Vec<f64>> =
            samples(solver, signal, loads)?.into_iter().map(inputs).collect();
        let count = samples.first().map_or(0, Vec::len);
        let (graph, stages) = record_groups(count, |inputs| source.follow_kernels(inputs));
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &samples);
        let guards = stages.each_ref().map(|stage| holds(&graph, stage, &guards, &mut merged));
        let stages = stages.map(|nodes| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        });
        Self::compile(&merged, count, &stages, guards).map(Arc::new)
    }

    fn compile(
        graph: &Graph,
        inputs: usize,
        stages: &[Vec<Node>; 2],
        guards: [Node; 2],
    ) -> Result<Self, RecordError> {
        let (ops, fuse) = (graph.ops(), fuses());
        let mut slots = Slots::of_inputs(ops, 0..inputs);
        let with = |stage: usize| -> Vec<Node> { [&stages[stage][..], &[guards[stage]]].concat() };
        let [motion, forces] = [with(0), with(1)];
        let shared = passed_on(ops, &motion, &forces, |_| true);
        let first = compile(ops, &[&motion[..], &shared].concat(), &mut slots, fuse);
        let second = compile(ops, &forces, &mut slots, fuse);
        let mut parts = [first, second];
        let mut results = [0..0, 0..0];
        for (stage, parts) in parts.iter_mut().enumerate() {
            // Results in successive slots are read faster.
            let from = slots.places(&stages[stage])?;
            let first = slots.reserve(from.len());
            let stores = from.into_iter().map(Source::Slot).zip(first..).collect();
            parts.push(Part::Code(Code { stores, ..Code::default() }));
            results[stage] = first as usize..slots.count();
        }
        let made = |stage: usize| -> Result<RecordedStage, RecordError> {
            Ok(RecordedStage {
                code: Runner::new(&parts[stage], 1, slots.count(), true),
                results: results[stage].clone(),
                guard: slots.place(guards[stage])?,
                operations: parts[stage].iter().map(Part::operations).sum(),
            })
        };
        let stages = [made(0)?, made(1)?];
        if !stages.iter().all(|stage| stage.code.is_machine_code()) {
            return Err(RecordError::NotNative);
        }
        let scratch = stages.iter().map(|stage| stage.code.scratch()).max().unwrap_or(0);
        Ok(Self { stages, slots: slots.count(), scratch })
    }

    /// Numbers of arithmetic operations of both stages.
    pub fn operations(&self) -> [usize; 2] {
        self.stages.each_ref().map(|stage| stage.operations)
    }

    fn stage(&self, stage: Stage) -> &RecordedStage {
        match stage {
            Stage::Motion => &self.stages[0],
            Stage::Forces => &self.stages[1],
        }
    }
}

impl KernelProgram for RecordedKernels {
    fn memory(&self) -> ProgramMemory {
        ProgramMemory { slots: vec![0.0; self.slots], scratch: vec![0.0; self.scratch] }
    }

    fn run(&self, stage: Stage, memory: &mut ProgramMemory) -> bool {
        let stage = self.stage(stage);
        stage.code.run(&mut memory.slots, &mut memory.scratch);
        memory.slots[stage.guard as usize] > 0.0
    }

    fn results(&self, stage: Stage) -> Range<usize> {
        self.stage(stage).results.clone()
    }
}

impl RecordingSource<'_> {
    /// Evaluates the kernels with recorded scalars. Returns the results of both stages.
    fn follow_kernels(&self, inputs: &[Recorded]) -> [Vec<Recorded>; 2] {
        let parameters = Parameters::<Recorded>::new(self.solver.mechanism());
        let settings = Settings {
            friction: FrictionMode::Off,
            position_steps: 0,
            rest_speed: 0.0,
            ..Settings::default()
        };
        let mut data = self.model.data(self.solver.state(), settings);
        let mut inputs = inputs.iter().copied();
        let mut next = || inputs.next().unwrap_or_else(Recorded::zero);
        data.state.coordinates.fill_with(&mut next);
        let targets: Vec<Target<Recorded>> = (0..self.counts(0).targets)
            .map(|_| Target { value: next(), rate: next(), acceleration: next() })
            .collect();
        let loads = self.read_loads(&mut next);
        self.model.evaluate(&parameters, &mut data, &targets, &loads);
        [motion_results(self.model, &data), force_results(self.model, &parameters, &data)]
    }
}
