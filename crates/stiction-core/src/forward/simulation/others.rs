//! Search for other accelerations and reactions that also satisfy all friction laws at the present
//! instant.

use super::{Event, EventKind, Simulation};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::mechanism::JointId;

impl Simulation<'_> {
    /// Searches for other solutions at the present instant if the uniqueness bound is one or more;
    /// a smaller bound proves that the solution is unique. Records any solutions found as an event.
    /// While the bound remains at one or more, only the first call searches.
    pub(super) fn look_for_others(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let Some(coupling) = self.now.coupling.filter(|c| *c >= 1.0) else {
            self.reported_others = false;
            return Ok(());
        };
        if self.reported_others || !self.settings.look_for_others {
            return Ok(());
        }
        self.reported_others = true;
        let model = self.model;
        let time = self.now.time;
        let situation = self.situation_of(self.now.state.clone(), inputs);
        let loads: Vec<f64> = self.now.interfaces.iter().map(|c| c.load).collect();
        let mut solved = model
            .solve(&situation, &self.modes, Some(&loads), false)
            .map_err(|u| model.unsolved(time, u))?;
        let others = model.others(&situation, &self.modes, &mut solved);
        let Some(other) = others.first() else { return Ok(()) };
        let differs = |c: &usize| (other.loads[*c] - loads[*c]).abs();
        let most = (0..loads.len()).max_by(|a, b| differs(a).total_cmp(&differs(b)));
        let joint = most.map_or(JointId(0), |c| model.reported_joint(c));
        let kind = EventKind::NotUnique { joint, coupling, others };
        self.events.push(Event { time, kind });
        Ok(())
    }
}
