//! Program of forward dynamics for one mechanism: accelerations and reactions, coupled with
//! friction.
//!
//! Accelerations and reactions are affine in the friction forces, and each friction force is affine
//! in the normal load of its interface. The program therefore has these stages: preparation without
//! friction; a Newton step for the normal loads; a chord step, which reuses the matrix of the last
//! Newton step and costs a third of a Newton step; and the results that follow from the normal
//! loads. A separate stage computes motion and reactions without friction. For the initial guess,
//! friction is computed from the frictionless normal loads. After one Newton step, each chord step
//! usually adds several correct digits; if not, another Newton step follows.

use crate::code::{Slots, compile};
use crate::compiled::Compiled;
use crate::convergence::Convergence;
use crate::error::RecordError;
use crate::forward_stages::ForwardStages;
use crate::graph::Node;
use crate::loaded::{LoadPlace, check_loads, place_of};
use crate::machine::fuses;
use crate::memory::Memory;
use crate::recording::{Counts, RecordingSource};
use crate::run::by_lanes;
use crate::samples::{StateRange, samples, seeded_samples};
use crate::stages::early;
use core::ops::Range;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Weighting};
use stiction_core::forward::{AccelerationProgram, ProgramInputs};
use stiction_core::kinematics::{ProgramMemory, State, Target};

/// Maximum number of iteration steps for the normal loads.
const STEPS: usize = 24;
/// Number of initial Newton steps.
const NEWTON_STEPS: usize = 1;
/// Index of the stage that computes motion and reactions without friction.
const IDEAL: usize = 0;
/// Index of the stage that prepares the computation with friction.
const FIRST: usize = 1;
/// Index of the stage that computes a Newton step for the normal loads.
const NEWTON: usize = 2;
/// Index of the stage that computes a chord step for the normal loads.
const CHORD: usize = 3;
/// Index of the stage that computes motion and reactions with friction from the normal loads.
const LAST: usize = 4;

/// Compiled program of forward dynamics for one mechanism. Computes accelerations and all reactions
/// from positions, velocities and all actuator efforts; the friction of sliding interfaces is
/// coupled with the reactions.
///
/// ```
/// use stiction_core::dynamics::{InverseDynamics, Settings};
/// use stiction_core::joint::JointType;
/// use stiction_core::kinematics::{Coordinate, Target};
/// use stiction_core::mechanism::{BodySpec, JointId, JointSpec, MechanismBuilder};
/// use stiction_core::spatial::Vec3;
/// use stiction_program::ForwardProgram;
///
/// let pendulum = MechanismBuilder::new("pendulum")
///     .gravity(Vec3::new(0.0, -9.81, 0.0))
///     .body(BodySpec::new("bob").mass(2.0).com(Vec3::new(0.5, 0.0, 0.0)))
///     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
///     .build()?;
/// let angle = Coordinate::Joint { joint: JointId(0), dof: 0 };
/// let at = |value| vec![Target { value, rate: 0.0, acceleration: 0.0 }];
/// let solver = InverseDynamics::new(pendulum, &[], &[angle], &at(0.0), Settings::default())?;
/// let signal: Vec<_> = (0..10).map(|k| at(0.1 * f64::from(k))).collect();
/// let program = ForwardProgram::record(&solver, &signal, &[])?;
///
/// let mut memory = program.memory(1);
/// let mut holds = [false];
/// program.set(&mut memory, 0, solver.state(), &[], &[0.0]);
/// program.run(&mut memory, &mut holds);
/// // Released in the horizontal position, it falls with g / l.
/// assert!(holds[0] && (program.acceleration(&memory, 0, 0) + 9.81 / 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ForwardProgram {
    counts: Counts,
    loaded: Vec<LoadPlace>,
    places: Places,
    code: Compiled<5>,
}

/// Slots of the program's results.
#[derive(Clone, Debug)]
struct Places {
    /// Slots of the initial guess of the normal loads of all coupled interfaces.
    start: Vec<u32>,
    /// Slots of the normal loads after a Newton step.
    newton: Vec<u32>,
    /// Slots of the normal loads after a chord step.
    chord: Vec<u32>,
    /// Slot of the determinant of the matrix of a Newton step.
    determinant: u32,
    /// Slot of the guard of the results without friction. Guards are positive while the assumptions
    /// made at recording hold.
    ideal_guard: u32,
    /// Slot of the guard of the results with friction.
    guard: u32,
    ideal: Motion,
    real: Motion,
    loads: Vec<u32>,
    velocities: Vec<u32>,
    frictions: Vec<u32>,
    /// Slots of the results of an [`AccelerationProgram`].
    collected: Vec<u32>,
    /// Successive slots to which these results are copied.
    results: Range<usize>,
}

/// Slots of the accelerations of the prescribed coordinates, the accelerations of the tree's
/// degrees of freedom, and the reactions of the joints.
#[derive(Clone, Debug)]
struct Motion {
    coordinates: Vec<u32>,
    tree: Vec<u32>,
    reactions: Vec<u32>,
}

impl Motion {
    fn new(places: &[u32], counts: &Counts) -> Self {
        let (coordinates, rest) = places.split_at(counts.targets);
        let (tree, rest) = rest.split_at(counts.dofs);
        let reactions = &rest[..6 * counts.joints];
        Self {
            coordinates: coordinates.to_vec(),
            tree: tree.to_vec(),
            reactions: reactions.to_vec(),
        }
    }
}

impl ForwardProgram {
    /// Records and compiles the program of a mechanism.
    ///
    /// The program computes the accelerations of the coordinates that `solver` prescribes, and all
    /// other accelerations from these; the number of coordinates must be that of the actuators.
    /// `signal` contains positions of these coordinates within the intended range of motion, each
    /// close enough to the previous one for the solver to follow. The solver starts from its
    /// present position. `loads` defines the loaded bodies, points and axes; the wrenches
    /// themselves are inputs.
    ///
    /// # Errors
    /// See [`RecordError`]: the errors of [`crate::InverseProgram::record`]; reactions are not
    /// unique, as in a planar linkage of revolute joints; bodies have local passive DOFs; the
    /// efforts do not determine the accelerations, because an actuated coordinate has no inertia or
    /// the numbers of actuators and coordinates differ; or the general kernel does not confirm the
    /// results of the program.
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
        let model = solver.model().map_err(|_| RecordError::NoPlan)?;
        let has_idle_spins = !solver.constraints().spins().is_empty();
        if solver.weighting() != Some(Weighting::Determined) {
            return Err(RecordError::Redundant);
        }
        if has_idle_spins {
            return Err(RecordError::IdleSpins);
        }
        if !solver.mechanism().drive_trains().is_empty() {
            return Err(RecordError::DriveTrains);
        }
        let source = RecordingSource { model: &model, solver, loads };
        let counts = source.counts(0);
        if counts.drives != counts.targets || counts.drives == 0 {
            let (actuators, coordinates) = (counts.drives, counts.targets);
            return Err(RecordError::ActuatorCount { actuators, coordinates });
        }
        let samples = samples(solver, signal, loads)?;
        let pivots = source.mass_pivots(&samples).ok_or(RecordError::NoInertia)?;
        let mut form = source.wrench_form(&samples);
        // A first recording with all interfaces determines the interfaces whose friction changes a
        // normal load.
        let all: Vec<usize> = (0..counts.interfaces).collect();
        let first = source.record_forward(&all, &pivots, &mut form, &samples);
        let couples = |interface: &usize| first.couples[*interface];
        let coupled: Vec<usize> = all.into_iter().filter(couples).collect();
        let recorded = match coupled.len() == counts.interfaces {
            true => first,
            false => source.record_forward(&coupled, &pivots, &mut form, &samples),
        };
        let places = loads.iter().map(place_of).collect();
        let program = Self::compile(source.counts(coupled.len()), &recorded, places, machine)?;
        // The program is verified at states other than those of the recording.
        let others = seeded_samples(9, StateRange::Usual, solver, signal, loads)?;
        if source.confirms(&program, &others) {
            Ok(program)
        } else {
            Err(RecordError::NotConfirmed)
        }
    }

    fn compile(
        counts: Counts,
        recorded: &ForwardStages,
        loaded: Vec<LoadPlace>,
        machine: bool,
    ) -> Result<Self, RecordError> {
        let ops = recorded.graph.ops();
        let fuse = machine && fuses();
        let given = counts.inputs() + counts.drives;
        let mut slots = Slots::of_inputs(ops, 0..given + 2 * counts.coupled);
        let mut stages = [const { Vec::new() }; 5];
        // The frictionless stage has its own slots, which no other stage reads.
        let mut own = slots.clone();
        let with = |nodes: &[Node], guard: Node| [nodes, &[guard]].concat();
        stages[IDEAL] = compile(ops, &with(&recorded.ideal, recorded.guards[0]), &mut own, fuse);
        let (ideal, ideal_guard) = (own.places(&recorded.ideal)?, own.place(recorded.guards[0])?);
        slots.reserve(own.count() - slots.count());

        let last = with(&recorded.rest, recorded.guards[1]);
        let later = [&recorded.newton[..], &recorded.chord, &last].concat();
        let mut first = recorded.begin.clone();
        first.extend(early(ops, &later, |input| input >= given));
        stages[FIRST] = compile(ops, &first, &mut slots, fuse);
        let mut newton = Vec::new();
        // If no friction changes a normal load, this stage never runs, and no other stage may
        // depend on it.
        if counts.coupled > 0 {
            newton.clone_from(&recorded.newton);
            newton.extend(early(ops, &recorded.chord, |input| input >= given + counts.coupled));
        }
        stages[NEWTON] = compile(ops, &newton, &mut slots, fuse);
        // The following stages run independently, so none of them may depend on values that another
        // stage has left in memory.
        let mut of_chord = slots.clone();
        stages[CHORD] = compile(ops, &recorded.chord, &mut of_chord, fuse);
        let chord = of_chord.places(&recorded.chord)?;
        slots.reserve(of_chord.count() - slots.count());
        stages[LAST] = compile(ops, &last, &mut slots, fuse);

        // A stage that never runs has no results.
        let newton = if counts.coupled > 0 { slots.places(&recorded.newton)? } else { Vec::new() };
        let (next, determinant) = newton.split_at(counts.coupled);
        let rest = slots.places(&recorded.rest)?;
        let moments = &rest[counts.targets + counts.dofs + 6 * counts.joints..];
        let (moments, moving) = moments.split_at(3 * counts.interfaces);
        let moment = |k: usize| moments[k * counts.interfaces..][..counts.interfaces].to_vec();
        let real = Motion::new(&rest, &counts);
        let (loads, frictions) = (moment(0), moment(2));
        let collected = [&real.tree[..], &loads, &frictions, moving, &real.reactions].concat();
        let results = slots.reserve(collected.len()) as usize..slots.count();
        let places = Places {
            start: slots.places(&recorded.begin)?,
            newton: next.to_vec(),
            chord,
            determinant: determinant.first().copied().unwrap_or(0),
            ideal_guard,
            guard: slots.place(recorded.guards[1])?,
            ideal: Motion::new(&ideal, &counts),
            real,
            loads,
            velocities: moment(1),
            frictions,
            collected,
            results,
        };
        let code = Compiled::new(stages, slots.count(), machine);
        Ok(Self { counts, loaded, places, code })
    }

    /// Number of states that the vector code processes in parallel on this processor.
    pub fn lanes(&self) -> usize {
        self.code.lanes()
    }

    /// Numbers of arithmetic operations: of the frictionless computation; and, with friction, of
    /// the preparation, of a Newton step, of a chord step, and of the final stage.
    pub fn operations(&self) -> [usize; 5] {
        self.code.operations()
    }

    /// Returns `true` for native machine code, `false` for an interpreted program.
    pub fn is_machine_code(&self) -> bool {
        self.code.is_machine_code()
    }

    /// Allocates memory for one state (`lanes` 1) or, for any other number, for [`Self::lanes`]
    /// states.
    pub fn memory(&self, lanes: usize) -> Memory {
        self.code.memory(lanes)
    }

    /// Sets position and rates, loads, and all actuator efforts (N or N m) of one lane. Efforts are
    /// in the order of [`stiction_core::mechanism::Mechanism::actuators`]. The state must close the
    /// loops; its accelerations are ignored. The results of the last run are not changed.
    ///
    /// # Panics
    /// If the lane does not exist, if the state is that of another mechanism, if the number of
    /// efforts differs from that of the actuators, or if a load differs from the recorded one in
    /// its body, point or axes.
    pub fn set(
        &self,
        memory: &mut Memory,
        lane: usize,
        state: &State<f64>,
        loads: &[AppliedLoad<f64>],
        efforts: &[f64],
    ) {
        // Inputs have no names, so a missing number would shift all later inputs.
        let given = [efforts.len(), state.coordinates.len(), state.rates.len()];
        let Counts { drives, coordinates, dofs, .. } = self.counts;
        let expected = [drives, coordinates, dofs];
        assert!(
            given == expected,
            "expected {expected:?} efforts, coordinates and rates, found {given:?}"
        );
        check_loads(&self.loaded, loads);
        let (coordinates, rates) = (&state.coordinates[..], &state.rates[..]);
        let inputs = ProgramInputs { coordinates, rates, loads, efforts };
        self.write(&inputs, memory.writer(lane));
    }

    /// Passes the inputs of the program to `put`, in the order of their slots.
    fn write(&self, inputs: &ProgramInputs<'_>, mut put: impl FnMut(&[f64])) {
        put(inputs.coordinates);
        put(inputs.rates);
        for load in inputs.loads {
            put(&load.force.to_array());
            put(&load.moment.to_array());
        }
        put(inputs.efforts);
    }

    /// Computes motion and reactions without friction, for [`Self::ideal_acceleration`] and
    /// [`Self::ideal_reaction`]. `holds` receives for each lane `true` if the assumptions of the
    /// program are satisfied, see [`Self::run`]. Results with friction remain those of the last
    /// [`Self::run`].
    ///
    /// # Panics
    /// If `holds` is shorter than the number of lanes, or the memory belongs to a smaller program.
    pub fn run_frictionless(&self, memory: &mut Memory, holds: &mut [bool]) {
        memory.check_flags(holds);
        self.code.runners(memory.lanes)[IDEAL].run(&mut memory.slots, &mut memory.scratch);
        for (lane, holds) in holds.iter_mut().enumerate().take(memory.lanes) {
            *holds = memory.read(self.places.ideal_guard, lane) > 0.0;
        }
    }

    /// Computes motion and reactions with friction; friction and reactions are iterated to
    /// round-off. `settled` receives for each lane `true` if the iteration has converged and the
    /// assumptions of the program are satisfied: all friction interfaces slide, normal loads do not
    /// vanish, and every branch is one that occurred in the samples. Otherwise the results are
    /// invalid, and [`stiction_core::forward`] must be used. Results without friction remain those
    /// of the last [`Self::run_frictionless`].
    ///
    /// # Panics
    /// If `settled` is shorter than the number of lanes, or the memory belongs to a smaller
    /// program.
    pub fn run(&self, memory: &mut Memory, settled: &mut [bool]) {
        memory.check_flags(settled);
        let Memory { lanes, slots, scratch } = memory;
        by_lanes!(*lanes, L => self.run_lanes::<L>(slots, scratch, settled));
    }

    fn run_lanes<const L: usize>(
        &self,
        slots: &mut [f64],
        scratch: &mut [f64],
        settled: &mut [bool],
    ) {
        let runners = self.code.runners(L);
        runners[FIRST].run(slots, scratch);
        self.take::<L>(slots, &self.places.start);
        let mut done = [self.counts.coupled == 0; L];
        let mut convergence = Convergence::<L>::new();
        let given = self.counts.inputs() + self.counts.drives;
        for step in 0..STEPS {
            if done == [true; L] {
                break;
            }
            let newton = step < NEWTON_STEPS || convergence.is_slow() || step >= STEPS / 2;
            runners[if newton { NEWTON } else { CHORD }].run(slots, scratch);
            let next = if newton { &self.places.newton } else { &self.places.chord };
            let (lanes, _) = slots.as_chunks::<L>();
            let loads = next.iter().map(|next| &lanes[*next as usize]).zip(&lanes[given..]);
            let determinant = &lanes[self.places.determinant as usize];
            done = convergence.after(newton, loads, determinant);
            self.take::<L>(slots, next);
        }
        runners[LAST].run(slots, scratch);
        let guard = slots.as_chunks::<L>().0[self.places.guard as usize];
        for ((settled, done), guard) in settled.iter_mut().zip(done).zip(guard) {
            *settled = done && guard > 0.0;
        }
    }

    /// Copies normal loads from the slots `from` to the inputs of the next Newton or chord step.
    fn take<const L: usize>(&self, slots: &mut [f64], from: &[u32]) {
        let given = self.counts.inputs() + self.counts.drives;
        let (slots, _) = slots.as_chunks_mut::<L>();
        for (k, from) in from.iter().enumerate() {
            let loads = slots[*from as usize];
            slots[given + k] = loads;
            slots[given + self.counts.coupled + k] = loads;
        }
    }

    /// Acceleration without friction of a coordinate that the recording solver prescribes, rad/s^2
    /// or m/s^2.
    pub fn ideal_acceleration(&self, memory: &Memory, lane: usize, coordinate: usize) -> f64 {
        memory.read(self.places.ideal.coordinates[coordinate], lane)
    }

    /// Acceleration without friction of a degree of freedom of the tree, with index and unit as in
    /// [`State::accelerations`].
    pub fn ideal_tree_acceleration(&self, memory: &Memory, lane: usize, dof: usize) -> f64 {
        memory.read(self.places.ideal.tree[dof], lane)
    }

    /// Joint wrench without friction, in the convention of [`Self::reaction`].
    pub fn ideal_reaction(&self, memory: &Memory, lane: usize, joint: usize) -> [f64; 6] {
        memory.wrench(&self.places.ideal.reactions, lane, joint)
    }

    /// Acceleration with friction of a coordinate that the recording solver prescribes, rad/s^2 or
    /// m/s^2.
    pub fn acceleration(&self, memory: &Memory, lane: usize, coordinate: usize) -> f64 {
        memory.read(self.places.real.coordinates[coordinate], lane)
    }

    /// Acceleration with friction of a degree of freedom of the tree, with index and unit as in
    /// [`State::accelerations`].
    pub fn tree_acceleration(&self, memory: &Memory, lane: usize, dof: usize) -> f64 {
        memory.read(self.places.real.tree[dof], lane)
    }

    /// Total wrench that the predecessor of a joint exerts on the successor: force, N, then moment
    /// about the joint's origin, N m, world axes.
    pub fn reaction(&self, memory: &Memory, lane: usize, joint: usize) -> [f64; 6] {
        memory.wrench(&self.places.real.reactions, lane, joint)
    }

    /// Normal load of a friction interface, N, its sliding velocity, m/s, and the magnitude of its
    /// friction force, N, in this order.
    pub fn interface(&self, memory: &Memory, lane: usize, interface: usize) -> [f64; 3] {
        let Places { loads, velocities, frictions, .. } = &self.places;
        [loads, velocities, frictions].map(|places| memory.read(places[interface], lane))
    }

    /// Numbers of prescribed coordinates, of degrees of freedom of the tree, of joints and of
    /// friction interfaces.
    pub fn sizes(&self) -> [usize; 4] {
        let Counts { targets, dofs, joints, interfaces, .. } = self.counts;
        [targets, dofs, joints, interfaces]
    }
}

impl AccelerationProgram for ForwardProgram {
    fn memory(&self) -> ProgramMemory {
        let Memory { slots, scratch, .. } = self.code.memory(1);
        ProgramMemory { slots: slots.to_vec(), scratch: scratch.to_vec() }
    }

    fn run(&self, memory: &mut ProgramMemory, inputs: &ProgramInputs<'_>) -> bool {
        let ProgramMemory { slots, scratch } = memory;
        let mut places = slots.iter_mut();
        self.write(inputs, |numbers| {
            numbers.iter().zip(&mut places).for_each(|(number, place)| *place = *number);
        });
        let mut settled = [false];
        self.run_lanes::<1>(slots, scratch, &mut settled);
        let Places { collected, results, .. } = &self.places;
        for (to, from) in results.clone().zip(collected) {
            slots[to] = slots[*from as usize];
        }
        settled[0]
    }

    fn results(&self) -> Range<usize> {
        self.places.results.clone()
    }
}
