//! Inverse dynamics of one mechanism as a program: driving forces, reactions, friction coupled to them.
//!
//! The program has three stages. The first finds what does not depend on friction. The second is a step of
//! Newton's method: friction is made linear in the reactions, where they were found before, and the balance
//! solved with it; it is repeated. The third finds all forces from the last step's unknowns.

mod making;

use crate::compiled::Compiled;
use crate::loaded::{LoadPlace, check_count, check_loads};
use crate::memory::Memory;
use crate::program_inputs::{BodyMotion, Given, StateOfMotion};
use crate::recording::Counts;
use crate::run::{MOST_LANES, Runner};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::kinematics::{State, Target};
use stiction_core::mechanism::BodyId;

/// Newton steps, at most.
const STEPS: usize = 12;
/// A step that changes no reaction by more than this part of the largest leaves an error of the square of
/// it: rounding.
const SETTLED: f64 = 1e-8;
/// Only errors smaller than this part are taken to be squared by a step.
const COARSE: f64 = 1e-3;
/// An error that is rounding, as a part of the largest reaction.
const ROUNDING: f64 = 1e-15;

/// Inverse dynamics of one mechanism, compiled.
#[derive(Debug)]
pub struct InverseProgram {
    given: Given,
    loaded: Vec<LoadPlace>,
    reads_targets: bool,
    counts: Counts,
    places: Places,
    code: Compiled<4>,
}

/// What finds slopes beside a program, in whose slots it begins.
#[derive(Debug)]
pub(crate) struct Beside {
    /// What does not depend on directions, one state at a time.
    pub(crate) preparation: Runner,
    /// All directions side by side, with slots of their own.
    pub(crate) directions: Runner,
    pub(crate) slots: usize,
    pub(crate) operations: [usize; 2],
    /// Slots of the results, among those of directions.
    pub(crate) slopes: Vec<u32>,
    /// Where it is positive what is taken for granted holds.
    pub(crate) guard: u32,
    /// For each joint with contacts the first slot of its reaction, which is to be handed on.
    pub(crate) reactions: Vec<(usize, usize)>,
}

/// The slots of the results.
#[derive(Clone, Debug)]
struct Places {
    /// What a step begins with, and where that is for the first one and after a step.
    from: Vec<u32>,
    start: Vec<u32>,
    next: Vec<u32>,
    /// Of a step: squares of what has changed and of what it is, summed; the determinant.
    control: [u32; 3],
    /// Positive where what the program takes for granted holds.
    ideal_guard: u32,
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
    /// How many states the wide code takes at once on this processor.
    pub fn lanes(&self) -> usize {
        self.code.lanes()
    }

    /// Arithmetic operations: of everything without friction; with friction of what comes first, of one
    /// step of the coupling, and of what comes last.
    pub fn operations(&self) -> [usize; 4] {
        self.code.operations()
    }

    /// Whether the processor runs the program itself; if not, it is interpreted.
    pub fn is_machine_code(&self) -> bool {
        self.code.is_machine_code()
    }

    /// Room for runs of one state (`lanes` 1) or, for any other number, of [`Self::lanes`] states.
    pub fn memory(&self, lanes: usize) -> Memory {
        self.code.memory(lanes)
    }

    /// The bodies whose motions are given to [`Self::set_bodies`]: those where chains meet.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + '_ {
        self.given.bodies()
    }

    /// The coordinates of the tree that a program has to be told, by their places: those that do not
    /// follow from the bodies' motions in closed form. Rates and accelerations follow from prescribed values.
    pub fn coordinates(&self) -> &[usize] {
        self.given.free()
    }

    /// Sets one lane's state of motion, prescribed values and loads. The state must close the loops. Results are still
    /// those of the last run.
    ///
    /// # Panics
    /// If there is no such lane, no target for each prescribed coordinate (where motions of bodies do
    /// not say all), or if loads are others than those for which
    /// the program was recorded in more than force and moment.
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
        self.given.visit(self.given.motions(state), &state.coordinates, targets, loads, put);
    }

    /// The same from the motions of [`Self::bodies`], in their order: inverse kinematics is a part of the
    /// program. `coordinates` are those of the whole tree; [`Self::coordinates`] of them are read.
    ///
    /// # Panics
    /// As [`Self::set`], and unless there are as many motions as [`Self::bodies`].
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
        let bodies = self.given.bodies().count();
        assert!(motions.len() == bodies, "{} motions of {bodies} bodies", motions.len());
        let (targets, put) = (self.read_of(targets), memory.writer(lane));
        self.given.visit(motions.iter().copied(), coordinates, targets, loads, put);
    }

    /// Sets all lanes at once, as [`Self::set_bodies`] does one; lanes that are left over get the last state.
    /// Without any nothing is set.
    ///
    /// # Panics
    /// As [`Self::set_bodies`], and if there are more states than lanes. Only with debug assertions it is looked at where
    /// loads act: for many states that takes a noticeable part of the time.
    pub fn set_lanes(&self, memory: &mut Memory, states: &[StateOfMotion<'_>]) {
        match memory.lanes {
            1 => self.set_all::<1>(memory, states),
            2 => self.set_all::<2>(memory, states),
            4 => self.set_all::<4>(memory, states),
            _ => self.set_all::<MOST_LANES>(memory, states),
        }
    }

    fn set_all<const L: usize>(&self, memory: &mut Memory, states: &[StateOfMotion<'_>]) {
        let Some(last) = states.last() else { return };
        assert!(states.len() <= L, "{} states for {L} lanes", states.len());
        let bodies = self.given.bodies().count();
        for StateOfMotion { bodies: motions, targets, loads, .. } in states {
            assert!(motions.len() == bodies, "{} motions of {bodies} bodies", motions.len());
            self.check_targets(targets);
            match cfg!(debug_assertions) {
                true => check_loads(&self.loaded, loads),
                false => check_count(&self.loaded, loads),
            }
        }
        let states = core::array::from_fn(|lane| states.get(lane).unwrap_or(last));
        let (slots, _) = memory.slots.as_chunks_mut::<L>();
        self.given.write_lanes(states, self.reads_targets, slots);
    }

    /// Inputs have no names of their own: one too few, and the next would be taken for it.
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
            "{found} targets for {expected} prescribed coordinates"
        );
    }

    /// Where motions of bodies say all, nobody reads what is prescribed.
    #[inline]
    fn read_of<'a>(&self, targets: &'a [Target<f64>]) -> &'a [Target<f64>] {
        if self.reads_targets { targets } else { &[] }
    }

    /// The motions of [`Self::bodies`] in a state of the tree.
    pub fn motions(&self, state: &State<f64>) -> Vec<BodyMotion<f64>> {
        self.given.motions(state).collect()
    }

    /// Everything without friction: [`Self::ideal_drive`] and [`Self::ideal_reaction`] afterwards.
    /// For each lane whether what the program takes for granted holds, see [`Self::run`]. Results with friction are
    /// still those of the last [`Self::run`].
    ///
    /// # Panics
    /// If `holds` is shorter than the memory has lanes, or the memory is that of a smaller program.
    pub fn run_frictionless(&self, memory: &mut Memory, holds: &mut [bool]) {
        memory.check_flags(holds);
        self.code.runners(memory.lanes)[0].run(&mut memory.slots, &mut memory.scratch);
        for (lane, holds) in holds.iter_mut().enumerate().take(memory.lanes) {
            *holds = memory.read(self.places.ideal_guard, lane) > 0.0;
        }
    }

    /// Everything with friction, coupled to round-off. For each lane whether friction and reactions are in
    /// balance and what the program takes for granted holds: that all contacts slide, that loads do not
    /// vanish, that no branch is taken that no sample took. Where not, results mean nothing, and
    /// [`stiction_core::dynamics::InverseDynamics::solve`] does it. Results without friction are still those of the last
    /// [`Self::run_frictionless`].
    ///
    /// # Panics
    /// If `settled` is shorter than the memory has lanes, or the memory is that of a smaller program.
    pub fn run(&self, memory: &mut Memory, settled: &mut [bool]) {
        memory.check_flags(settled);
        let runners = self.code.runners(memory.lanes);
        match memory.lanes {
            1 => self.run_lanes::<1>(runners, memory, settled),
            2 => self.run_lanes::<2>(runners, memory, settled),
            4 => self.run_lanes::<4>(runners, memory, settled),
            _ => self.run_lanes::<MOST_LANES>(runners, memory, settled),
        }
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
        // Squares of changes in the last step, as parts of the whole; of none nothing is to be concluded.
        let mut changes = [0.0; L];
        for _ in 0..STEPS {
            runners[2].run(slots, scratch);
            let control = self.places.control.map(|place| slots.as_chunks::<L>().0[place as usize]);
            // Where friction does not depend on reactions there is nothing to repeat.
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

    /// A drive without friction, N or N m.
    pub fn ideal_drive(&self, memory: &Memory, lane: usize, drive: usize) -> f64 {
        memory.read(self.places.ideal_drives[drive], lane)
    }

    /// A joint's wrench without friction, as [`Self::reaction`].
    pub fn ideal_reaction(&self, memory: &Memory, lane: usize, joint: usize) -> [f64; 6] {
        memory.wrench(&self.places.ideal_reactions, lane, joint)
    }

    /// A drive with friction, N or N m.
    pub fn drive(&self, memory: &Memory, lane: usize, drive: usize) -> f64 {
        memory.read(self.places.drives[drive], lane)
    }

    /// A joint's complete wrench, predecessor on successor: force, then moment about the joint's origin,
    /// world axes.
    pub fn reaction(&self, memory: &Memory, lane: usize, joint: usize) -> [f64; 6] {
        memory.wrench(&self.places.reactions, lane, joint)
    }

    /// The load on a contact, N; its sliding velocity, m/s; and its friction force, N, not negative.
    pub fn interface(&self, memory: &Memory, lane: usize, interface: usize) -> [f64; 3] {
        let Places { loads, velocities, frictions, .. } = &self.places;
        [loads, velocities, frictions].map(|places| memory.read(places[interface], lane))
    }

    /// Numbers of drives, joints and contacts.
    pub fn sizes(&self) -> (usize, usize, usize) {
        (self.counts.drives, self.counts.joints, self.counts.interfaces)
    }
}

/// Whether the last step leaves nothing but rounding. Newton's steps square the error: what
/// one has changed is the error before it, and the last two tell by what factor the square counts. Given are
/// the squares of changes and of reactions, and the determinant.
#[inline]
fn settle<const L: usize>(control: [[f64; L]; 3], changes: &mut [f64; L]) -> [bool; L] {
    let [change, size, determinant] = control;
    core::array::from_fn(|lane| {
        let (before, now) = (changes[lane], change[lane] / size[lane]);
        changes[lane] = now;
        // What is left is `now^2 now / before^2` or less; of a change that is no number nothing is to hope.
        let left = now * now * now;
        let few = now < COARSE * COARSE
            && left <= ROUNDING * ROUNDING * before * before
            && left <= ROUNDING * ROUNDING;
        (now <= SETTLED * SETTLED || few) && determinant[lane] > 0.0
    })
}
