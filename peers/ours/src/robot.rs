//! A gallery robot along its default motion, under its default load.

use crate::expected::{Expected, Forces};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Model, Settings};
use stiction_core::kinematics::{State, Target};
use stiction_core::spatial::Vec3;
use stiction_format::{ModelFile, Motion, Source, gallery, read};

/// Number of instants if there is no file of expected forces.
const INSTANTS: usize = 100;

pub(crate) struct Robot {
    pub(crate) solver: InverseDynamics,
    pub(crate) compiled: Model,
    /// At each instant, the prescribed values, the loads, and the position of the tree.
    pub(crate) targets: Vec<Vec<Target<f64>>>,
    pub(crate) loads: Vec<Vec<AppliedLoad<f64>>>,
    pub(crate) positions: Vec<State<f64>>,
    /// Joint of each of the expected reactions.
    pub(crate) joints: Vec<usize>,
}

impl Robot {
    pub(crate) fn new(name: &str, expected: &Expected) -> Result<Self, String> {
        let model = model(name)?;
        let motion = default_motion(&model)?;
        let default = |name: &Option<String>| name.clone().ok_or("the model has no default");
        let load = model.load(&default(&model.default_load)?).ok_or("no such load")?;
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let start: Vec<_> = motion.at(expected.times[0]).collect();
        let (first, last) = (expected.times[0], expected.times[expected.times.len() - 1]);
        let (mechanism, load) = load
            .attached(&model.mechanism, (first, last))
            .map_err(|_| "the default load picks up or places a payload".to_owned())?;
        let mut solver = InverseDynamics::new(
            mechanism,
            &model.initial_poses,
            &coordinates,
            &start,
            Settings::default(),
        )
        .map_err(|error| error.to_string())?;
        let compiled = solver.model().map_err(|error| error.to_string())?;
        let joint = |name: &String| solver.mechanism().joint_id(name).map(|id| id.0);
        let joints = expected.joints.iter().map(joint).collect::<Option<_>>();
        let joints = joints.ok_or("the expected reactions are of other joints")?;

        let (mut targets, mut loads, mut positions) = (Vec::new(), Vec::new(), Vec::new());
        let mut before = expected.times[0];
        for &time in &expected.times {
            let follow = |t: f64, targets: &mut [Target<f64>]| {
                targets.iter_mut().zip(motion.at(t)).for_each(|(target, at)| *target = at);
            };
            solver.follow(before, time, follow).map_err(|error| error.to_string())?;
            before = time;
            targets.push(motion.at(time).collect());
            loads.push(load.at(time).collect());
            positions.push(solver.state().clone());
        }
        Ok(Self { solver, compiled, targets, loads, positions, joints })
    }
}

fn model(name: &str) -> Result<ModelFile, String> {
    let text = gallery::get(name).ok_or("no such model in the gallery")?;
    read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into()))
        .map_err(|_| "the model is not accepted".to_owned())
}

fn default_motion(model: &ModelFile) -> Result<&Motion, String> {
    let name = model.default_motion.as_ref().ok_or("the model has no default")?;
    model.motion(name).ok_or_else(|| "no such motion".to_owned())
}

/// Forces that the general solver computes along the default motion, with and without friction.
pub(crate) fn solved(name: &str) -> Result<Expected, String> {
    let model = model(name)?;
    let motion = default_motion(&model)?;
    let instant = |k: usize| motion.start + motion.duration * k as f64 / INSTANTS as f64;
    let joints = model.mechanism.joints().iter().map(|joint| joint.name.clone()).collect();
    let mut expected = Expected {
        joints,
        times: (0..=INSTANTS).map(instant).collect(),
        frictionless: Vec::new(),
        with_friction: Vec::new(),
    };
    let mut robot = Robot::new(name, &expected)?;
    for k in 0..expected.times.len() {
        let moved = robot.solver.move_to(&robot.targets[k]);
        moved.map_err(|error| error.to_string())?;
        for friction in [FrictionMode::Off, FrictionMode::Converged] {
            robot.solver.settings_mut().friction = friction;
            let forces = robot.solver.solve(&robot.loads[k]).map_err(|error| error.to_string())?;
            let wrench = |(force, moment): &(Vec3<f64>, Vec3<f64>)| {
                let ([a, b, c], [d, e, f]) = (force.to_array(), moment.to_array());
                [a, b, c, d, e, f]
            };
            let list = match friction {
                FrictionMode::Off => &mut expected.frictionless,
                _ => &mut expected.with_friction,
            };
            list.push(Forces {
                drives: forces.efforts.clone(),
                reactions: forces.reactions.iter().map(wrench).collect(),
            });
        }
    }
    Ok(expected)
}
