//! Recorded program in place of the general solver, for simulations with many control periods.

use super::acting_inputs::prescribed;
use super::job::Job;
use std::sync::Arc;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Settings};
use stiction_core::forward::Forward;
use stiction_core::kinematics::{Bodies, Coordinate, State, Target};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Pose;
use stiction_program::ForwardProgram;

/// Least number of control periods for which recording a program takes less time than it saves.
const MANY: f64 = 2000.0;
/// Number of instants of the motion near which the program is recorded.
const INSTANTS: usize = 10;

impl Job<'_> {
    /// Lets the model of this job, between the times `from` and `until`, s, compute by a recorded
    /// program, if there are so many control periods that this saves time and if a program can be
    /// recorded. `start` is the initial state of the mechanism. Without a program, the general
    /// solver computes all steps.
    pub(super) fn record_program(
        &self,
        forward: &mut Forward,
        start: &State<f64>,
        (from, until): (f64, f64),
    ) {
        let periods = self.control.map_or(0.0, |control| (until - from) / control.period);
        let is_sampled = periods.is_finite() && periods >= MANY;
        let Some(motion) = self.motion.filter(|_| is_sampled && prescribed(self).is_empty()) else {
            return;
        };
        let (topology, parameters) = (forward.topology(), forward.parameters());
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &start.coordinates);
        let mechanism = &self.model.mechanism;
        let (ground, origin) = (mechanism.base().inverse(), parameters.origin);
        let poses: Vec<(BodyId, Pose<f64>)> = (1..mechanism.bodies().len())
            .map(|body| {
                let pose = bodies.pose[body];
                (BodyId(body), ground * Pose { position: pose.position + origin, ..pose })
            })
            .collect();
        let coordinates: Vec<Coordinate> =
            motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let signal: Vec<Vec<Target<f64>>> = (0..INSTANTS)
            .map(|k| motion.start + motion.duration * k as f64 / INSTANTS as f64)
            .map(|time| motion.at(time).collect())
            .collect();
        let settings = Settings::default();
        let solver =
            InverseDynamics::new(mechanism.clone(), &poses, &coordinates, &signal[0], settings);
        let Ok(solver) = solver else { return };
        // Large models of forward dynamics have other spanning trees.
        let sizes = |state: &State<f64>| [state.coordinates.len(), state.rates.len()];
        if sizes(solver.state()) != sizes(start) {
            return;
        }
        let mut loads: Vec<AppliedLoad<f64>> = self.load.at(from).collect();
        loads.extend(self.load.laws.iter().map(|law| law.load(0.0)));
        if let Ok(program) = ForwardProgram::record(&solver, &signal, &loads) {
            forward.use_program(Arc::new(program), &coordinates, &loads);
        }
    }
}
