//! Sudden changes of inputs, such as a controller sample or a step change of a force.

use super::locate::SLIP_EXCESS;
use super::{REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::Instant;

impl Simulation<'_> {
    /// Updates accelerations and reactions after a change of the inputs. Searches for new
    /// stick-slip modes only if the present modes are not clearly valid, because the search is many
    /// times as expensive.
    pub(super) fn on_input_change(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if let Some(instant) = self.goes_on(inputs) {
            self.count_motion(&instant);
            self.become_now(instant);
            return self.look_for_others(inputs);
        }
        self.reconsider(inputs, None)
    }

    fn goes_on(&mut self, inputs: &mut dyn Inputs) -> Option<Instant> {
        let still = self.is_still();
        let clear =
            self.modes.iter().zip(&self.now.interfaces).all(|(mode, interface)| match mode {
                InterfaceMode::Smooth | InterfaceMode::Sticks => true,
                InterfaceMode::AtLimit(_) => false,
                InterfaceMode::Slides(_) => norm(interface.velocity) > REST * self.fastest,
            });
        // At rest the present frictions hold as long as none exceeds its limit, which includes this factor.
        if !clear || self.limit_factor != 1.0 && !still {
            return None;
        }
        let mut y = self.list();
        self.pack_into(&mut y);
        let time = self.now.time;
        let found = match still {
            true => self.watch(time, &y, true, inputs),
            false => {
                let known = (self.needs_bound(), Some(self.now.distance));
                self.evaluate_at(time, &y, inputs, known)
            }
        };
        self.lists.push(y);
        let mut instant = found.ok()?;
        self.keep_bound(&mut instant);
        // If the static friction forces are statically indeterminate, the mode search distributes
        // them again, unless the mechanism is at rest.
        let sticks = self.modes.contains(&InterfaceMode::Sticks);
        let shared = sticks && instant.redundant > 0 && !still;
        let unique = instant.coupling.is_some_and(|coupling| coupling < 1.0);
        let holds = self.least_margin(&instant) > 2.0 * SLIP_EXCESS;
        if shared || !unique || !holds {
            self.workspace.spare(instant);
            return None;
        }
        Some(instant)
    }
}
