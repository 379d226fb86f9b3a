//! The general kernels as timed computations, for one state at a time and for eight states in
//! parallel.
//!
//! The kernels receive the prescribed motion and compute the position of the tree, starting from
//! the position at the previous state. The other engines receive all coordinates of their trees.

use crate::expected::{Difference, Expected, Forces};
use crate::robot::Robot;
use crate::subject::Subject;
use std::hint::black_box;
use stiction_core::dynamics::{AppliedLoad, Data, FrictionMode, Settings};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::scalar::{Lanes, Scalar};

const LANES: usize = 8;
type L = Lanes<f64, LANES>;

/// All timed kernels.
pub(crate) fn subjects<'a>(robot: &'a Robot, expected: &'a Expected) -> Vec<Subject<'a>> {
    let mut subjects = Vec::new();
    for (single, lanes, friction, forces) in [
        (
            "kernel_frictionless",
            "kernel_lanes_frictionless",
            FrictionMode::Off,
            &expected.frictionless,
        ),
        (
            "kernel_friction",
            "kernel_lanes_friction",
            FrictionMode::Converged,
            &expected.with_friction,
        ),
    ] {
        let settings = Settings { friction, ..Settings::default() };
        subjects.push(Runs::new(robot, settings, single_states(robot)).subject(single, forces));
        subjects.push(Runs::new(robot, settings, lanes_of_states(robot)).subject(lanes, forces));
    }
    subjects
}

/// Inputs of one run. With eight lanes, the states of neighbouring lanes are an eighth of the
/// motion apart, so that each lane also follows the motion.
struct Run<T> {
    targets: Vec<Target<T>>,
    loads: Vec<AppliedLoad<T>>,
    /// The sample in each lane.
    samples: Vec<usize>,
}

fn single_states(robot: &Robot) -> Vec<Run<f64>> {
    let runs = robot.targets.iter().zip(&robot.loads).enumerate();
    runs.map(|(i, (targets, loads))| Run {
        targets: targets.clone(),
        loads: loads.clone(),
        samples: vec![i],
    })
    .collect()
}

fn lanes_of_states(robot: &Robot) -> Vec<Run<L>> {
    let samples = robot.targets.len();
    let steps = samples.div_ceil(LANES);
    (0..steps)
        .map(|step| {
            // Lanes overlap by a few states if eight does not divide their number.
            let at = |lane: usize| lane * (samples - steps) / (LANES - 1) + step;
            let target = |k: usize| Target {
                value: L::from_fn(|lane| robot.targets[at(lane)][k].value),
                rate: L::from_fn(|lane| robot.targets[at(lane)][k].rate),
                acceleration: L::from_fn(|lane| robot.targets[at(lane)][k].acceleration),
            };
            // Loads of the default cases are constant in time.
            Run {
                targets: (0..robot.targets[0].len()).map(target).collect(),
                loads: robot.loads[0].iter().map(|load| load.lift()).collect(),
                samples: (0..LANES).map(at).collect(),
            }
        })
        .collect()
}

/// A kernel that is evaluated at the states of a motion again and again.
struct Runs<'a, T> {
    robot: &'a Robot,
    parameters: Parameters<T>,
    data: Data<T>,
    runs: Vec<Run<T>>,
    /// Position at the beginning of the motion, for each lane.
    start: Vec<T>,
    next: usize,
}

impl<'a, T: InLanes> Runs<'a, T> {
    fn new(robot: &'a Robot, settings: Settings, runs: Vec<Run<T>>) -> Self {
        let parameters = Parameters::<T>::new(robot.solver.mechanism());
        let data: Data<T> = robot.compiled.data(&robot.positions[0], settings);
        let mut start = data.state.coordinates.clone();
        for (lane, &sample) in runs[0].samples.iter().enumerate() {
            for (coordinate, &value) in start.iter_mut().zip(&robot.positions[sample].coordinates) {
                coordinate.set_lane(lane, value);
            }
        }
        Self { robot, parameters, data, runs, start, next: 0 }
    }

    fn subject(mut self, name: &'static str, expected: &'a [Forces]) -> Subject<'a>
    where
        T: 'a,
    {
        let difference = self.difference(expected);
        let lanes = self.runs[0].samples.len();
        let batch = Box::new(move |count: usize| {
            let runs = count.div_ceil(lanes);
            for _ in 0..runs {
                self.step();
            }
            black_box(self.data.inverse.efforts());
            runs * lanes
        });
        Subject { name, difference, batch }
    }

    #[inline(never)]
    fn step(&mut self) -> &Run<T> {
        let run = &self.runs[self.next];
        let Self { robot, parameters, data, start, .. } = self;
        if self.next == 0 {
            data.state.coordinates.copy_from_slice(start);
        }
        robot.compiled.evaluate(parameters, data, black_box(&run.targets), &run.loads);
        self.next = if self.next + 1 == self.runs.len() { 0 } else { self.next + 1 };
        run
    }

    /// Largest difference from `expected` after all states have been evaluated twice, as in the
    /// measurement.
    fn difference(&mut self, expected: &[Forces]) -> f64 {
        let mut difference = Difference::default();
        for _ in 0..2 * self.runs.len() {
            let samples = self.step().samples.clone();
            let (inverse, bodies) = (&self.data.inverse, &self.data.kinematics.bodies);
            for (lane, &sample) in samples.iter().enumerate() {
                let forces = &expected[sample];
                for (drive, &wanted) in inverse.efforts().iter().zip(&forces.drives) {
                    difference.add_drive(drive.lane(lane), wanted);
                }
                for (&joint, &wanted) in self.robot.joints.iter().zip(&forces.reactions) {
                    let (force, moment) = inverse.reaction(bodies, joint);
                    let got = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
                    difference.add_reaction(got.map(|x| x.lane(lane)), wanted);
                }
            }
        }
        difference.relative()
    }
}

/// A scalar that holds one number or several.
trait InLanes: Scalar {
    fn lane(&self, lane: usize) -> f64;
    fn set_lane(&mut self, lane: usize, value: f64);
}

impl InLanes for f64 {
    fn lane(&self, _: usize) -> f64 {
        *self
    }

    fn set_lane(&mut self, _: usize, value: f64) {
        *self = value;
    }
}

impl InLanes for L {
    fn lane(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }
}
