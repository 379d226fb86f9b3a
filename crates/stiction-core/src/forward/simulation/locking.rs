//! Locks of sticking joints. A lock keeps the joint coordinates exactly constant, so that round-off
//! does not accumulate to a drift.

use super::{Event, EventKind, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::project::Anchor;
use crate::topology::Role;

impl Simulation<'_> {
    /// Returns the locks of the given sticking interfaces: anchors for cut joints, and a flag for
    /// each degree of freedom of the spanning tree that is true if the degree of freedom is locked.
    pub(super) fn holds_of(&self, interfaces: &[usize]) -> (Vec<Anchor>, Vec<bool>) {
        let topology = &self.model.topology;
        let mut anchors = Vec::new();
        let mut frozen = vec![false; topology.dofs()];
        for &interface in interfaces {
            let content = &self.model.parameters.interfaces[interface];
            let joint = content.joint;
            for (place, dof) in content.shape.dofs().enumerate() {
                let driven = self.model.is_prescribed_place(interface, place);
                match topology.role[joint] {
                    _ if driven => {}
                    Role::Tree { node } => {
                        frozen[topology.nodes[node].tree_dofs.start + dof] = true;
                    }
                    Role::Cut { .. } => {
                        let (j, k) =
                            (self.now.bodies.frame_j[joint], self.now.bodies.frame_k[joint]);
                        anchors.push(Anchor { joint, dof, pose: j.inverse() * k });
                    }
                }
            }
        }
        (anchors, frozen)
    }

    /// Locks the joints of all sticking interfaces, or the whole mechanism if its mobility is zero.
    /// If any interface sticks, also recomputes the present accelerations and forces.
    pub(super) fn hold(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let model = self.model;
        self.workspace.conditions_hold = false;
        let sticks: Vec<usize> =
            (0..self.modes.len()).filter(|&c| self.modes[c] == InterfaceMode::Sticks).collect();
        (self.anchors, self.frozen) = self.holds_of(&sticks);
        if sticks.is_empty() {
            self.reported_shares = 0;
            return Ok(());
        }
        let mut state = self.now.state.clone();
        let situation = self.situation_of(state.clone(), inputs);
        let loads: Vec<f64> = self.now.interfaces.iter().map(|c| c.load).collect();
        let solved = model
            .solve(&situation, &self.modes, Some(&loads), true)
            .map_err(|u| model.unsolved(situation.time, u))?;
        // The whole mechanism is locked only if no mobility is left. In a moving mechanism, a
        // degree of freedom without mobility may be at a dead centre and is not locked.
        if model.prescribed.is_empty() && solved.balance.mobility(model.topology.dofs()) == 0 {
            self.frozen.fill(true);
        }
        for (rate, frozen) in state.rates.iter_mut().zip(&self.frozen) {
            if *frozen {
                *rate = 0.0;
            }
        }
        let redundant = solved.balance.redundant();
        let without = self.permanently_redundant(&situation);
        let shares = redundant.saturating_sub(without);
        if shares > 0 && shares != self.reported_shares {
            let kind = EventKind::SharesNotUnique { redundant: shares };
            self.events.push(Event { time: self.now.time, kind });
        }
        self.reported_shares = shares;
        let situation = self.situation_of(state, inputs);
        self.now = model.instant(&situation, &self.modes, &solved);
        self.restart_bound();
        self.still();
        Ok(())
    }

    /// Returns the number of constraints that remain redundant if no interface sticks.
    pub(super) fn permanently_redundant(&self, situation: &crate::forward::data::Data) -> usize {
        self.model.mobility(situation, &[]).map_or(0, |(_, redundant)| redundant)
    }

    /// Sets the accelerations of locked degrees of freedom to zero.
    pub(super) fn still(&mut self) {
        for (acceleration, frozen) in self.now.state.accelerations.iter_mut().zip(&self.frozen) {
            if *frozen {
                *acceleration = 0.0;
            }
        }
    }
}
