//! Programs recorded for the robot as straight-line machine code, for one state at a time and for
//! as many states in parallel as the processor has SIMD lanes.
//!
//! The other engines receive the complete state of the tree. Programs receive only the motion of
//! the platform and include inverse kinematics.

use crate::expected::{Difference, Expected, Forces};
use crate::robot::Robot;
use crate::subject::Subject;
use std::hint::black_box;
use stiction_program::{BodyMotion, ForwardProgram, InverseProgram, Memory, StateOfMotion};

/// Number of positions along the motion at which a program is recorded.
const COURSE: usize = 10;
/// Largest number of lanes of any processor.
const MOST_LANES: usize = 8;

/// All timed programs; empty if the robot has no program.
pub(crate) fn subjects<'a>(robot: &'a Robot, expected: &'a Expected) -> Vec<Subject<'a>> {
    let samples = robot.targets.len();
    let signal: Vec<_> = (0..COURSE).map(|k| robot.targets[k * samples / COURSE].clone()).collect();
    let record = || InverseProgram::record(&robot.solver, &signal, &robot.loads[0]);
    let mut subjects = Vec::new();
    for (single, wide, friction, forces) in [
        ("inverse_frictionless", "lanes_frictionless", false, &expected.frictionless),
        ("inverse_friction", "lanes_friction", true, &expected.with_friction),
    ] {
        for (name, is_wide) in [(single, false), (wide, true)] {
            let Ok(program) = record() else { continue };
            subjects.push(Runs::new(robot, program, is_wide, friction).subject(name, forces));
        }
    }
    for (single, wide, friction, forces) in [
        ("forward_frictionless", "forward_lanes_frictionless", false, &expected.frictionless),
        ("forward", "forward_lanes", true, &expected.with_friction),
    ] {
        for (name, is_wide) in [(single, false), (wide, true)] {
            let program = ForwardProgram::record(&robot.solver, &signal, &robot.loads[0]);
            let Ok(program) = program else { continue };
            subjects
                .push(ForwardRuns::new(robot, program, is_wide, friction, forces).subject(name));
        }
    }
    subjects
}

/// Index of the sample in a lane at a step. The ranges of the lanes overlap if the number of lanes
/// does not divide the number of samples.
fn sample(samples: usize, lanes: usize, lane: usize, step: usize) -> usize {
    let steps = samples.div_ceil(lanes);
    match lanes {
        1 => step,
        lanes => lane * (samples - steps) / (lanes - 1) + step,
    }
}

/// A program that is evaluated at the states of a motion again and again.
struct Runs<'a> {
    robot: &'a Robot,
    program: InverseProgram,
    motions: Vec<Vec<BodyMotion<f64>>>,
    memory: Memory,
    lanes: usize,
    friction: bool,
    settled: Vec<bool>,
    /// For each step, the samples in its lanes.
    order: Vec<Vec<usize>>,
    next: usize,
}

impl<'a> Runs<'a> {
    fn new(robot: &'a Robot, program: InverseProgram, is_wide: bool, friction: bool) -> Self {
        let lanes = if is_wide { program.lanes() } else { 1 };
        let (memory, settled) = (program.memory(lanes), vec![false; lanes]);
        let motions = robot.positions.iter().map(|state| program.motions(state)).collect();
        let samples = robot.targets.len();
        let steps = samples.div_ceil(lanes);
        let row = |step| (0..lanes).map(|lane| sample(samples, lanes, lane, step)).collect();
        let order = (0..steps).map(row).collect();
        Self { robot, program, motions, memory, lanes, friction, settled, order, next: 0 }
    }

    #[inline(never)]
    fn step(&mut self) -> usize {
        let step = self.next;
        let (samples, robot) = (&self.order[step], self.robot);
        let state = |sample: usize| StateOfMotion {
            bodies: black_box(&self.motions[sample]),
            coordinates: &robot.positions[sample].coordinates,
            targets: &robot.targets[sample],
            loads: &robot.loads[sample],
        };
        if let [sample] = samples[..] {
            self.program.set_lanes(&mut self.memory, &[state(sample)]);
        } else {
            let states: [_; MOST_LANES] =
                std::array::from_fn(|lane| state(samples[lane.min(samples.len() - 1)]));
            self.program.set_lanes(&mut self.memory, &states[..samples.len()]);
        }
        if self.friction {
            self.program.run(&mut self.memory, &mut self.settled);
        } else {
            self.program.run_frictionless(&mut self.memory, &mut self.settled);
        }
        self.next = if step + 1 == self.order.len() { 0 } else { step + 1 };
        step
    }

    fn subject(mut self, name: &'static str, expected: &'a [Forces]) -> Subject<'a> {
        let difference = self.difference(expected);
        let lanes = self.lanes;
        let batch = Box::new(move |count: usize| {
            let runs = count.div_ceil(lanes);
            for _ in 0..runs {
                self.step();
            }
            black_box(&self.memory);
            runs * lanes
        });
        Subject { name, difference, batch }
    }

    /// Evaluates all states once and returns the largest difference. Returns infinity if more than
    /// one state in twenty requires the general solver, for example because an interface is at
    /// rest.
    fn difference(&mut self, expected: &[Forces]) -> f64 {
        let mut difference = Difference::default();
        let mut left_out = 0;
        for _ in 0..self.order.len() {
            let step = self.step();
            for lane in 0..self.lanes {
                if !self.settled[lane] {
                    left_out += 1;
                    continue;
                }
                let forces = &expected[self.order[step][lane]];
                let Self { program, memory, robot, .. } = &*self;
                for (k, &wanted) in forces.drives.iter().enumerate() {
                    let drive = match self.friction {
                        true => program.drive(memory, lane, k),
                        false => program.ideal_drive(memory, lane, k),
                    };
                    difference.add_drive(drive, wanted);
                }
                for (&joint, &wanted) in robot.joints.iter().zip(&forces.reactions) {
                    let reaction = match self.friction {
                        true => program.reaction(memory, lane, joint),
                        false => program.ideal_reaction(memory, lane, joint),
                    };
                    difference.add_reaction(reaction, wanted);
                }
            }
        }
        if 20 * left_out > self.robot.targets.len() {
            return f64::INFINITY;
        }
        difference.relative()
    }
}

/// A program of forward dynamics that is evaluated at the states of a motion again and again. Like
/// the other engines, it receives the position and velocity of the tree, loads, and the actuator
/// forces of the motion.
struct ForwardRuns<'a> {
    robot: &'a Robot,
    program: ForwardProgram,
    memory: Memory,
    lanes: usize,
    friction: bool,
    settled: Vec<bool>,
    next: usize,
    expected: &'a [Forces],
}

impl<'a> ForwardRuns<'a> {
    fn new(
        robot: &'a Robot,
        program: ForwardProgram,
        is_wide: bool,
        friction: bool,
        expected: &'a [Forces],
    ) -> Self {
        let lanes = if is_wide { program.lanes() } else { 1 };
        let (memory, settled) = (program.memory(lanes), vec![false; lanes]);
        Self { robot, program, memory, lanes, friction, settled, next: 0, expected }
    }

    fn sample(&self, lane: usize, step: usize) -> usize {
        sample(self.robot.targets.len(), self.lanes, lane, step)
    }

    #[inline(never)]
    fn step(&mut self) -> usize {
        let step = self.next;
        for lane in 0..self.lanes {
            let sample = self.sample(lane, step);
            let Self { robot, program, memory, expected, .. } = self;
            let state = &robot.positions[sample];
            let (loads, efforts) = (&robot.loads[sample], &expected[sample].drives);
            program.set(memory, lane, black_box(state), loads, efforts);
        }
        if self.friction {
            self.program.run(&mut self.memory, &mut self.settled);
        } else {
            self.program.run_frictionless(&mut self.memory, &mut self.settled);
        }
        let steps = self.robot.targets.len().div_ceil(self.lanes);
        self.next = if step + 1 == steps { 0 } else { step + 1 };
        step
    }

    fn subject(mut self, name: &'static str) -> Subject<'a> {
        let difference = self.difference();
        let lanes = self.lanes;
        let batch = Box::new(move |count: usize| {
            let runs = count.div_ceil(lanes);
            for _ in 0..runs {
                self.step();
            }
            black_box(&self.memory);
            runs * lanes
        });
        Subject { name, difference, batch }
    }

    /// Evaluates accelerations and reactions of all states once and returns the largest difference.
    /// Returns infinity if more than one state in twenty requires the general solver, for example
    /// because an interface is at rest.
    fn difference(&mut self) -> f64 {
        let mut difference = Difference::default();
        let mut left_out = 0;
        for _ in 0..self.robot.targets.len().div_ceil(self.lanes) {
            let step = self.step();
            for lane in 0..self.lanes {
                if !self.settled[lane] {
                    left_out += 1;
                    continue;
                }
                let sample = self.sample(lane, step);
                let Self { program, memory, robot, expected, .. } = &*self;
                for (k, &wanted) in robot.positions[sample].accelerations.iter().enumerate() {
                    let found = match self.friction {
                        true => program.tree_acceleration(memory, lane, k),
                        false => program.ideal_tree_acceleration(memory, lane, k),
                    };
                    difference.add_acceleration(found, wanted);
                }
                for (&joint, &wanted) in robot.joints.iter().zip(&expected[sample].reactions) {
                    let reaction = match self.friction {
                        true => program.reaction(memory, lane, joint),
                        false => program.ideal_reaction(memory, lane, joint),
                    };
                    difference.add_reaction(reaction, wanted);
                }
            }
        }
        if 20 * left_out > self.robot.targets.len() {
            return f64::INFINITY;
        }
        difference.relative()
    }
}
