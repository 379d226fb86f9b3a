//! A robot of the gallery along its default motion, under its default load.

use crate::expected::Expected;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Model, Settings};
use stiction_core::kinematics::{State, Target};
use stiction_format::{Source, gallery, read};

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
        let text = gallery::get(name).ok_or("no such model in the gallery")?;
        let model = read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into()))
            .map_err(|_| "the model is not accepted")?;
        let default = |name: &Option<String>| name.clone().ok_or("the model has no default");
        let motion = model.motion(&default(&model.default_motion)?).ok_or("no such motion")?;
        let load = model.load(&default(&model.default_load)?).ok_or("no such load")?;
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let start: Vec<_> = motion.at(expected.times[0]).collect();
        let mechanism = model.mechanism.clone();
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
