//! Program of inverse dynamics for one mechanism: actuator forces and reactions, coupled with
//! friction.
//!
//! The computation with friction has three stages. The first computes everything that does not
//! depend on friction. The second is a Newton step, which is repeated: it linearises friction about
//! the current reactions and solves the force balance with this friction. The third computes all
//! forces from the unknowns of the last Newton step. A separate stage computes only the forces
//! without friction.

mod record;

use crate::compiled::Compiled;
use crate::loaded::{LoadPlace, check_count, check_loads};
use crate::memory::Memory;
use crate::program_inputs::{BodyMotion, InputLayout, StateOfMotion};
use crate::recording::Counts;
use crate::run::{Runner, by_lanes};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::kinematics::{State, Target};
use stiction_core::mechanism::BodyId;

/// Maximum number of Newton steps.
pub(crate) const STEPS: usize = 12;
/// If a Newton step changes the reactions or normal loads by at most this fraction, the remaining
/// error is of the order of the square of this change, and counts as rounding.
pub(crate) const SETTLED: f64 = 1e-8;
/// Quadratic convergence is assumed only if the relative change of the reactions is below this
/// value.
pub(crate) const COARSE: f64 = 1e-3;
/// Rounding error of the reactions or normal loads, relative to the largest one.
pub(crate) const ROUNDING: f64 = 1e-15;

/// Compiled program of inverse dynamics for one mechanism.
#[derive(Debug)]
pub struct InverseProgram {
    layout: InputLayout,
    loaded: Vec<LoadPlace>,
    reads_targets: bool,
    counts: Counts,
    places: Places,
    code: Compiled<4>,
}

/// Code that computes derivatives in addition to a program of inverse dynamics. Its preparation
/// shares the memory slots of that program.
#[derive(Debug)]
pub(crate) struct DerivativeCode {
    /// Operations that do not depend on directions, for one state at a time.
    pub(crate) preparation: Runner,
    /// Operations for several directions in parallel lanes, with separate memory slots.
    pub(crate) directions: Runner,
    pub(crate) slots: usize,
    /// Numbers of arithmetic operations of `preparation` and of `directions`.
    pub(crate) operations: [usize; 2],
    /// Slots of the resulting derivatives, in the memory of `directions`.
    pub(crate) slopes: Vec<u32>,
    /// Slot of the guard of the derivatives, which is positive while the assumptions made at
    /// recording hold.
    pub(crate) guard: u32,
    /// Indices of the joints with friction interfaces, each with the first of six slots that
    /// receive the reaction of the joint.
    pub(crate) reactions: Vec<(usize, usize)>,
}

/// Slots of the program's results.
#[derive(Clone, Debug)]
struct Places {
    /// Slots of the inputs of a Newton step.
    from: Vec<u32>,
    /// Slots of the values that are copied to the slots `from` before the first Newton step.
    start: Vec<u32>,
    /// Slots of the values that are copied to the slots `from` after each Newton step.
    next: Vec<u32>,
    /// Slots of three numbers: the sums of squares of the changes and of the values in a Newton
    /// step, and the determinant of its matrix.
    control: [u32; 3],
    /// Slot of the guard of the results without friction. Guards are positive while the assumptions
    /// made at recording hold.
    ideal_guard: u32,
    /// Slot of the guard of the results with friction.
    guard: u32,
    ideal_drives: Vec<u32>,
    ideal_reactions: Vec<u32>,
    drives: Vec<u32>,
    reactions: Vec<u32>,
    loads: Vec<u32>,
    velocities: Vec<u32>,
    frictions: Vec<u32>,
}

impl InverseProgram {
    /// Number of states that the vector code processes in parallel on this processor.
    pub fn lanes(&self) -> usize {
        self.code.lanes()
    }

    /// Numbers of arithmetic operations: of the frictionless computation; and, with friction, of
    /// the preparation, of one Newton step, and of the final stage.
    pub fn operations(&self) -> [usize; 4] {
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

    /// Bodies whose motions are arguments of [`Self::set_bodies`]: the floating bodies of the
    /// spanning tree, where kinematic chains meet.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + '_ {
        self.layout.bodies()
    }

    /// Indices of the tree coordinates that are inputs, because they do not follow from the motions
    /// of [`Self::bodies`] in closed form. Their rates and accelerations follow from the prescribed
    /// values.
    pub fn coordinates(&self) -> &[usize] {
        self.layout.free()
    }

    /// Sets the state of motion, prescribed values and loads of one lane. The state must close the
    /// loops. The results of the last run are not changed.
    ///
    /// # Panics
    /// If the lane does not exist, if the number of targets differs from that of the prescribed
    /// coordinates (unless the motions of bodies determine everything), or if a load differs from
    /// the recorded one in its body, point or axes.
    pub fn set(
        &self,
        memory: &mut Memory,
        lane: usize,
        state: &State<f64>,
        targets: &[Target<f64>],
        loads: &[AppliedLoad<f64>],
    ) {
        self.check(targets, loads);
        let (targets, put) = (self.read_of(targets), memory.writer(lane));
        self.layout.visit(self.layout.motions(state), &state.coordinates, targets, loads, put);
    }

    /// Sets the inputs of one lane from the motions of [`Self::bodies`], in the order of these
    /// bodies. `coordinates` are all coordinates of the tree; the program reads only those in
    /// [`Self::coordinates`].
    ///
    /// # Panics
    /// In the cases of [`Self::set`], and if the number of motions differs from that of
    /// [`Self::bodies`].
    pub fn set_bodies(
        &self,
        memory: &mut Memory,
        lane: usize,
        motions: &[BodyMotion<f64>],
        coordinates: &[f64],
        targets: &[Target<f64>],
        loads: &[AppliedLoad<f64>],
    ) {
        self.check(targets, loads);
        let bodies = self.layout.bodies().count();
        assert!(
            motions.len() == bodies,
            "expected motions of {bodies} bodies, found {}",
            motions.len()
        );
        let (targets, put) = (self.read_of(targets), memory.writer(lane));
        self.layout.visit(motions.iter().copied(), coordinates, targets, loads, put);
    }

    /// Sets the inputs of all lanes at once, as [`Self::set_bodies`] does for one lane. Unused
    /// lanes repeat the last state. An empty slice changes no lane.
    ///
    /// # Panics
    /// In the cases of [`Self::set_bodies`], and if the states outnumber the lanes. Bodies, points
    /// and axes of loads are checked only with debug assertions, because the check takes noticeable
    /// time for many states.
    pub fn set_lanes(&self, memory: &mut Memory, states: &[StateOfMotion<'_>]) {
        by_lanes!(memory.lanes, L => self.set_all::<L>(memory, states));
    }

    fn set_all<const L: usize>(&self, memory: &mut Memory, states: &[StateOfMotion<'_>]) {
        let Some(last) = states.last() else { return };
        assert!(states.len() <= L, "{} states for {L} lanes", states.len());
        let bodies = self.layout.bodies().count();
        for StateOfMotion { bodies: motions, targets, loads, .. } in states {
            assert!(
                motions.len() == bodies,
                "expected motions of {bodies} bodies, found {}",
                motions.len()
            );
            self.check_targets(targets);
            match cfg!(debug_assertions) {
                true => check_loads(&self.loaded, loads),
                false => check_count(&self.loaded, loads),
            }
        }
        let states = core::array::from_fn(|lane| states.get(lane).unwrap_or(last));
        let (slots, _) = memory.slots.as_chunks_mut::<L>();
        self.layout.write_lanes(states, self.reads_targets, slots);
    }

    /// Panics if the number of prescribed values or of loads differs from that of the recording, or
    /// if a load differs from the recorded one in its body, point or axes. Inputs have no names, so
    /// a missing input would shift all later inputs.
    #[inline]
    pub(crate) fn check(&self, targets: &[Target<f64>], loads: &[AppliedLoad<f64>]) {
        self.check_targets(targets);
        check_loads(&self.loaded, loads);
    }

    #[inline]
    fn check_targets(&self, targets: &[Target<f64>]) {
        let (found, expected) = (targets.len(), self.counts.targets);
        assert!(
            found == expected || !self.reads_targets,
            "expected {expected} targets, one for each prescribed coordinate, found {found}"
        );
    }

    /// Returns the targets, or an empty slice if the motions of bodies determine all coordinates.
    #[inline]
    fn read_of<'a>(&self, targets: &'a [Target<f64>]) -> &'a [Target<f64>] {
        if self.reads_targets { targets } else { &[] }
    }

    /// Computes the motions of [`Self::bodies`], in the order of these bodies, from a state of the
    /// tree.
    pub fn motions(&self, state: &State<f64>) -> Vec<BodyMotion<f64>> {
        self.layout.motions(state).collect()
    }

    /// Computes forces without friction, for [`Self::ideal_drive`] and [`Self::ideal_reaction`].
    /// `holds` receives for each lane `true` if the assumptions of the program are satisfied, see
    /// [`Self::run`]. Results with friction remain those of the last [`Self::run`].
    ///
    /// # Panics
    /// If `holds` is shorter than the number of lanes, or the memory belongs to a smaller program.
    pub fn run_frictionless(&self, memory: &mut Memory, holds: &mut [bool]) {
        memory.check_flags(holds);
        self.code.runners(memory.lanes)[0].run(&mut memory.slots, &mut memory.scratch);
        for (lane, holds) in holds.iter_mut().enumerate().take(memory.lanes) {
            *holds = memory.read(self.places.ideal_guard, lane) > 0.0;
        }
    }

    /// Computes forces with friction; friction and reactions are iterated to round-off. `settled`
    /// receives for each lane `true` if the iteration has converged and the assumptions of the
    /// program are satisfied: all friction interfaces slide, normal loads do not vanish, and every
    /// branch is one that occurred in the samples. Otherwise the results are invalid, and
    /// [`stiction_core::dynamics::InverseDynamics::solve`] must be used. Results without friction
    /// remain those of the last [`Self::run_frictionless`].
    ///
    /// # Panics
    /// If `settled` is shorter than the number of lanes, or the memory belongs to a smaller
    /// program.
    pub fn run(&self, memory: &mut Memory, settled: &mut [bool]) {
        memory.check_flags(settled);
        let runners = self.code.runners(memory.lanes);
        by_lanes!(memory.lanes, L => self.run_lanes::<L>(runners, memory, settled));
    }

    fn run_lanes<const L: usize>(
        &self,
        runners: &[Runner; 4],
        memory: &mut Memory,
        settled: &mut [bool],
    ) {
        let Memory { slots, scratch, .. } = memory;
        runners[1].run(slots, scratch);
        let copy = |slots: &mut [f64], from: &[u32]| {
            let (slots, _) = slots.as_chunks_mut::<L>();
            for (to, from) in self.places.from.iter().zip(from) {
                slots[*to as usize] = slots[*from as usize];
            }
        };
        copy(slots, &self.places.start);
        let mut done = [false; L];
        // Squared relative changes of the previous step. Before the first step they are zero, which
        // permits no conclusion about convergence.
        let mut changes = [0.0; L];
        for _ in 0..STEPS {
            runners[2].run(slots, scratch);
            let control = self.places.control.map(|place| slots.as_chunks::<L>().0[place as usize]);
            // No iteration is needed if friction does not depend on reactions.
            done =
                if self.places.from.is_empty() { [true; L] } else { settle(control, &mut changes) };
            if done == [true; L] {
                break;
            }
            copy(slots, &self.places.next);
        }
        runners[3].run(slots, scratch);
        let guard = slots.as_chunks::<L>().0[self.places.guard as usize];
        for ((settled, done), guard) in settled.iter_mut().zip(done).zip(guard) {
            *settled = done && guard > 0.0;
        }
    }

    /// Actuator force without friction, N or N m.
    pub fn ideal_drive(&self, memory: &Memory, lane: usize, drive: usize) -> f64 {
        memory.read(self.places.ideal_drives[drive], lane)
    }

    /// Joint wrench without friction, in the convention of [`Self::reaction`].
    pub fn ideal_reaction(&self, memory: &Memory, lane: usize, joint: usize) -> [f64; 6] {
        memory.wrench(&self.places.ideal_reactions, lane, joint)
    }

    /// Actuator force with friction, N or N m.
    pub fn drive(&self, memory: &Memory, lane: usize, drive: usize) -> f64 {
        memory.read(self.places.drives[drive], lane)
    }

    /// Total wrench that the predecessor of a joint exerts on the successor: force, N, then moment
    /// about the joint's origin, N m, world axes.
    pub fn reaction(&self, memory: &Memory, lane: usize, joint: usize) -> [f64; 6] {
        memory.wrench(&self.places.reactions, lane, joint)
    }

    /// Normal load of a friction interface, N, its sliding velocity, m/s, and the magnitude of its
    /// friction force, N, in this order.
    pub fn interface(&self, memory: &Memory, lane: usize, interface: usize) -> [f64; 3] {
        let Places { loads, velocities, frictions, .. } = &self.places;
        [loads, velocities, frictions].map(|places| memory.read(places[interface], lane))
    }

    /// Numbers of actuators, joints and friction interfaces.
    pub fn sizes(&self) -> (usize, usize, usize) {
        (self.counts.drives, self.counts.joints, self.counts.interfaces)
    }
}

/// Tests for each lane whether the iteration has converged to rounding. `control` contains the sum
/// of squares of the changes in the last Newton step, that of the values, and the determinant of
/// the step's matrix. `changes` contains the squared relative changes of the previous step, and
/// receives those of the last step. A Newton step squares the error: the change in a step
/// approximates the error before the step, and the last two changes determine the factor of the
/// quadratic convergence.
#[inline]
pub(crate) fn settle<const L: usize>(control: [[f64; L]; 3], changes: &mut [f64; L]) -> [bool; L] {
    let [change, size, determinant] = control;
    core::array::from_fn(|lane| {
        let (before, now) = (changes[lane], change[lane] / size[lane]);
        changes[lane] = now;
        // The remaining error is at most `now^2 now / before^2`, for the roots of these squares.
        // NaN satisfies no condition.
        let left = now * now * now;
        let few = now < COARSE * COARSE
            && left <= ROUNDING * ROUNDING * before * before
            && left <= ROUNDING * ROUNDING;
        (now <= SETTLED * SETTLED || few) && determinant[lane] > 0.0
    })
}
