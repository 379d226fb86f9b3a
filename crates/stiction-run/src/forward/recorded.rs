//! Recorded program in place of the general solver, for simulations with many control periods.

use super::acting_inputs::prescribed;
use super::job::Job;
use crate::bodies::poses_from_ground;
use std::sync::Arc;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics, Settings};
use stiction_core::forward::Forward;
use stiction_core::kinematics::{Bodies, Coordinate, State, Target};
use stiction_program::ForwardProgram;

/// Number of control periods, per friction interface, from which a program is used. In most runs
/// that are twice as long, recording the program takes less time than it saves. The number does not
/// depend on the end of the run, so that a run that is resumed with a later end has the same digits
/// as an uninterrupted one.
const PERIODS: f64 = 40.0;
/// Least number of control periods from which a program is used.
const LEAST_PERIODS: f64 = 400.0;
/// Number of DOFs of the spanning tree from which no program is recorded: recording would take too
/// long, and large models of forward dynamics have other trees than inverse dynamics.
const LARGE: usize = 60;
/// Number of instants of the motion near which the program is recorded.
const INSTANTS: usize = 10;

impl Job<'_> {
    /// Lets the model of this job, which is simulated between the times `from` and `until`, s,
    /// compute by a recorded program after many control periods, see [`PERIODS`], if `until` is
    /// later and if a program can be recorded. `start` is the initial state of the mechanism.
    /// Without a program, the general solver computes all steps.
    pub(super) fn record_program(
        &self,
        forward: &mut Forward,
        start: &State<f64>,
        (from, until): (f64, f64),
    ) {
        let period = self.control.map_or(0.0, |control| control.period);
        let interfaces = forward.parameters().interfaces.len();
        let use_from = from + (PERIODS * interfaces as f64).max(LEAST_PERIODS) * period;
        let is_used = period > 0.0 && until > use_from && prescribed(self).is_empty();
        let Some(motion) = self.motion.filter(|_| is_used) else { return };
        let (topology, parameters) = (forward.topology(), forward.parameters());
        if topology.dofs() >= LARGE {
            return;
        }
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &start.coordinates);
        let poses = poses_from_ground(forward, &bodies);
        let coordinates: Vec<Coordinate> =
            motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let signal: Vec<Vec<Target<f64>>> = (0..INSTANTS)
            .map(|k| motion.start + motion.duration * k as f64 / INSTANTS as f64)
            .map(|time| motion.at(time).collect())
            .collect();
        let (mechanism, settings) = (self.model.mechanism.clone(), Settings::default());
        let solver = InverseDynamics::new(mechanism, &poses, &coordinates, &signal[0], settings);
        let Ok(solver) = solver else { return };
        let mut loads: Vec<AppliedLoad<f64>> = self.load.at(from).collect();
        loads.extend(self.load.laws.iter().map(|law| law.load(0.0)));
        // An interpreted program takes more time than the general solver.
        if let Ok(program) = ForwardProgram::record(&solver, &signal, &loads)
            && program.is_machine_code()
        {
            forward.use_program(Arc::new(program), &loads, use_from);
        }
    }
}
