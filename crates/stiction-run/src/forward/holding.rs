//! Static friction at an equilibrium: the range of efforts within which friction holds the
//! mechanism at the equilibrium, and a check whether friction holds it where the search for the
//! equilibrium starts.

use super::acting_inputs::{Acting, prescribed};
use super::controller::by_actuators;
use super::equilibrium::Equilibrium;
use super::job::Job;
use super::motors::Motors;
use super::start;
use crate::error::Error;
use crate::names::Names;
use serde_json::{Value, json};
use std::fmt;
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{Forward, InterfaceMode};
use stiction_core::kinematics::{Bodies, State, Target};
use stiction_draw::numbers::number;

/// Acceleration, as a fraction of the characteristic acceleration, below which a mechanism counts
/// as being at rest.
const RESTS: f64 = 1e-9;

/// Width of the column of names, characters.
const WIDE: usize = 24;

/// Range of the effort of one actuator within which static friction holds the mechanism at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct HoldingRange {
    /// Name of the actuator.
    pub name: String,
    /// Unit of the effort, N or N m.
    pub unit: &'static str,
    /// Least and greatest effort, N or N m, for which static friction holds the mechanism at rest.
    pub range: (f64, f64),
}

/// Effect of static friction at an equilibrium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holding {
    /// For each actuator, the range of efforts that hold the mechanism at the equilibrium; empty if
    /// the ranges are unknown.
    pub ranges: Vec<HoldingRange>,
    /// Reason why the ranges are unknown; `None` if they are known.
    pub unknown: Option<String>,
    /// True if, with the given efforts, friction holds the mechanism where the search starts, so
    /// that it does not move to the equilibrium; `None` if this is undecided.
    pub rests_at_start: Option<bool>,
}

impl Holding {
    /// Returns the results as JSON.
    pub(super) fn json(&self) -> Value {
        let range = |one: &HoldingRange| {
            let (low, high) = one.range;
            (one.name.clone(), json!({ "unit": one.unit, "low": low, "high": high }))
        };
        json!({
            "holding": self.ranges.iter().map(range).collect::<serde_json::Map<_, _>>(),
            "unknown_because": self.unknown,
            "rests_at_start": self.rests_at_start,
        })
    }

    /// Writes the results as text for the terminal.
    pub(super) fn write(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.ranges.is_empty() {
            writeln!(f, "\nefforts that hold this position with static friction")?;
        }
        for HoldingRange { name, unit, range: (low, high) } in &self.ranges {
            writeln!(f, "  {name:WIDE$} {:>13} to {:>9} {unit}", number(*low), number(*high))?;
        }
        if let Some(reason) = &self.unknown {
            writeln!(
                f,
                "efforts that hold this position with static friction are not known: {reason}"
            )?;
        }
        match self.rests_at_start {
            Some(true) => writeln!(
                f,
                "static friction holds the mechanism at the start of the search: with these \
                 efforts it does not move to this equilibrium"
            ),
            Some(false) => {
                writeln!(
                    f,
                    "static friction does not hold the mechanism at the start of the search"
                )
            }
            None => Ok(()),
        }
    }
}

impl Job<'_> {
    /// Computes the effect of static friction at an equilibrium that was found without friction.
    ///
    /// # Errors
    /// Fails if the mechanism cannot be assembled in the initial state of the job.
    pub fn holding(&self, found: &Equilibrium) -> Result<Holding, Error> {
        if !self.load.payloads.is_empty() {
            let (model, load) = self.with_payloads()?;
            let job = Job { model: &model, load: &load, ..self.clone() };
            return job.holding(found);
        }
        let forward = Forward::new(self.model.mechanism.clone(), &prescribed(self));
        let (mut at_start, _) = start::state(self, &forward)?;
        at_start.rates.fill(0.0);
        let mut holding =
            Holding { rests_at_start: self.rests(&forward, at_start), ..Holding::default() };
        match self.ranges(&found.state) {
            Ok(ranges) => holding.ranges = ranges,
            Err(error) => holding.unknown = Some(error.to_string()),
        }
        Ok(holding)
    }

    /// Returns true if the mechanism remains at rest in `state` under the efforts of the job: no
    /// joint accelerates and no friction interface slides. `None` if the accelerations have no
    /// solution.
    fn rests(&self, forward: &Forward, state: State<f64>) -> Option<bool> {
        let going = || false;
        let mut acting = Acting::new(self, forward, &state, &going).ok()?;
        let simulation = forward.start(self.from, state, self.settings, &mut acting).ok()?;
        let parameters = forward.parameters();
        let natural = (parameters.gravity.norm() / parameters.length).max(1e-3);
        let now = simulation.instant();
        let still = |a: &f64| a.abs() <= RESTS * natural * parameters.length.max(1.0);
        let slides = |mode: &InterfaceMode| matches!(mode, InterfaceMode::Slides(_));
        Some(
            now.state.accelerations.iter().all(still)
                && !simulation.interfaces().iter().any(slides),
        )
    }

    /// Computes, for each actuator, the range of efforts within which static friction holds the
    /// mechanism in `state`, an equilibrium that was found without friction.
    fn ranges(&self, state: &State<f64>) -> Result<Vec<HoldingRange>, Error> {
        // The state refers to the spanning tree of the model without friction. With friction, the
        // spanning tree may also contain motor shafts.
        let tree = Forward::new(self.model.mechanism.without_friction(), &[]);
        let forward = &tree;
        let mut bodies = Bodies::new(forward.topology());
        bodies.place(forward.topology(), forward.parameters(), &state.coordinates);
        let rest = State {
            rates: vec![0.0; state.rates.len()],
            accelerations: vec![0.0; state.accelerations.len()],
            ..state.clone()
        };
        bodies.move_with(forward.topology(), &rest.rates);
        bodies.accelerate(forward.topology(), &rest.accelerations);
        let mut model = by_actuators(self.model, forward, (&rest, &bodies))?;
        model.settings_mut().friction = FrictionMode::Converged;
        let targets: Vec<Target<f64>> = forward
            .mechanism()
            .actuators()
            .map(|(joint, dof)| forward.joint_motion(&rest, &bodies, joint, dof))
            .collect();
        model.move_to(&targets).map_err(Error::Controller)?;
        let loads = self.loads_without_state()?;
        let forces = model.solve(&loads).map_err(Error::ControllerForces)?;
        let (mut low, mut high): (Vec<f64>, Vec<f64>) =
            forces.effort_bounds.iter().copied().unzip();
        let motors = Motors::new(&self.model.mechanism);
        motors.widen(&mut low, &mut high)?;
        let names = Names::new(&self.model.mechanism).drives.into_iter();
        let ranges = names.zip(low.into_iter().zip(high));
        Ok(ranges.map(|((name, unit), range)| HoldingRange { name, unit, range }).collect())
    }
}
