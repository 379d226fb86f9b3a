//! Accelerations and reactions with friction, for given stick-slip modes of all interfaces.

use super::Forward;
use super::affine_friction::{AffineFriction, InterfaceMode, affine_friction};
use super::balance::{Balance, Massless, Workspace};
use super::constraint_jacobian::{ConstrainedDof, ConstraintRows, StickingDof};
use super::coupling::{Coupled, Coupling};
use super::data::{Data, FrictionDistribution};
use super::error::{Competitor, ForwardError};
use crate::friction_problem::continuation::Lock;
use crate::kinematics::{Bodies, Target};
use crate::spatial::Wrench;

/// Smallest number of DOFs of the spanning tree for which the decision between stick and slip uses
/// the sparse solver. For smaller mechanisms, it uses the dense solver.
const LARGE: usize = 150;

/// Accelerations and reactions for given modes of the interfaces, with the factorised equations of
/// motion and buffers for reuse.
#[derive(Clone, Debug, Default)]
pub(super) struct Solved {
    pub(super) coupled: Coupled,
    pub(super) balance: Balance,
    pub(super) constrained: Vec<ConstrainedDof>,
    pub(super) sticking: Vec<StickingDof>,
    pub(super) frictions: Vec<AffineFriction>,
    /// Uniqueness bound of the normal loads, if computed.
    pub(super) coupling_bound: Option<f64>,
    /// Relative error of the normal loads at which their iteration may end; zero for round-off.
    pub(super) load_tolerance: f64,
    /// True if the uniqueness bound at the start of the step is at most [`super::coupling::CERTAIN`].
    pub(super) is_weak: bool,
    coupling: Coupling,
    efforts: Vec<(usize, Wrench<f64>)>,
    workspace: Workspace,
}

impl Solved {
    /// Returns the number of continuation steps in the last solution; zero if it needed no
    /// continuation.
    pub(super) fn continuation_steps(&self) -> usize {
        self.coupling.continuation_steps()
    }
}

/// Reason why given modes have no solution.
pub(super) enum Unsolved {
    /// Friction locks the mechanism: the normal loads grow without bound before the friction
    /// coefficients reach their full values, see [`Lock`].
    Locked(Lock),
    /// A body can move without inertia.
    Massless(Massless),
}

impl Forward {
    /// Lists the DOFs that are constrained in the given modes: DOFs of actuators with prescribed
    /// motion, and DOFs of sticking interfaces. Friction does not constrain a DOF whose motion is
    /// prescribed.
    pub(super) fn constrain(
        &self,
        targets: &[Target<f64>],
        modes: &[InterfaceMode],
        distribution: &FrictionDistribution,
        constrained: &mut Vec<ConstrainedDof>,
        sticking: &mut Vec<StickingDof>,
    ) {
        constrained.clear();
        sticking.clear();
        for (&actuator, target) in self.prescribed.iter().zip(targets) {
            let actuator = self.topology.actuators[actuator];
            let at = (actuator.joint, actuator.dof);
            constrained.push(ConstrainedDof::actuated(at, target.acceleration));
        }
        for (index, (interface, mode)) in self.parameters.interfaces.iter().zip(modes).enumerate() {
            if *mode != InterfaceMode::Sticks {
                continue;
            }
            for (place, dof) in interface.shape.dofs().enumerate() {
                let joint = interface.joint;
                // A prescribed DOF already has a constraint row.
                if !targets.is_empty() && self.is_prescribed_place(index, place) {
                    continue;
                }
                sticking.push(StickingDof { interface: index, place, row: constrained.len() });
                let arm = interface.arms(self.parameters.pitch[joint])[place];
                let scale = arm * distribution.scales.get(index).copied().unwrap_or(1.0);
                let reference =
                    -arm * distribution.reference_frictions.get(index).map_or(0.0, |r| r[place]);
                constrained.push(ConstrainedDof {
                    joint,
                    dof,
                    acceleration: 0.0,
                    actuated: false,
                    scale,
                    reference,
                });
            }
        }
    }

    /// Computes the constraint rows and the constraint Jacobian for the given modes.
    pub(super) fn constraint_rows(
        &self,
        bodies: &Bodies<f64>,
        targets: &[Target<f64>],
        modes: &[InterfaceMode],
    ) -> ConstraintRows {
        let (mut constrained, mut rows) = (Vec::new(), ConstraintRows::default());
        self.constrain(
            targets,
            modes,
            &FrictionDistribution::default(),
            &mut constrained,
            &mut Vec::new(),
        );
        rows.update(&self.topology, &self.parameters, bodies, &constrained);
        rows
    }

    /// Factorises the equations of motion for the given modes. All static frictions have the scale
    /// one (see [`FrictionDistribution::scales`]).
    pub(super) fn balance(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
    ) -> Result<Balance, Massless> {
        Balance::new(self, data, self.constraint_rows(&data.bodies, &data.targets, modes))
    }

    /// Returns the friction of an interface in a given mode, as an affine function of its normal
    /// load.
    pub(super) fn friction(
        &self,
        data: &Data,
        interface: usize,
        mode: InterfaceMode,
    ) -> AffineFriction {
        let content = &self.parameters.interfaces[interface];
        let pitch = self.parameters.pitch[content.joint];
        let (velocity, bristles) = (data.velocities[interface], data.bristles[interface]);
        affine_friction(content, pitch, mode, velocity, bristles)
    }

    /// Solves the equations of motion for given modes, starting from the normal loads `known`. If
    /// `bound`, also computes the uniqueness bound. Uses the dense solver except for large
    /// mechanisms and mechanisms without dry friction: decisions between stick and slip compare
    /// accelerations with round-off, which is smaller in the dense solution.
    pub(super) fn solve(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        known: Option<&[f64]>,
        bound: bool,
    ) -> Result<Solved, Unsolved> {
        let mut solved = Solved::default();
        let is_decided = modes.iter().any(|mode| *mode != InterfaceMode::Smooth);
        solved.balance.stays_dense = is_decided && self.topology.dofs() < LARGE;
        self.solve_into(data, modes, known, bound, &mut solved)?;
        Ok(solved)
    }

    /// Solves like [`Self::solve`], reusing the buffers.
    pub(super) fn solve_into(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        known: Option<&[f64]>,
        bound: bool,
        solved: &mut Solved,
    ) -> Result<(), Unsolved> {
        let Solved { balance, constrained, sticking, workspace, coupling, .. } = solved;
        coupling.forget_influence();
        self.constrain(&data.targets, modes, &data.distribution, constrained, sticking);
        balance.rows.update_rows(&self.topology, &self.parameters, &data.bodies, constrained);
        balance.update(self, data, workspace).map_err(Unsolved::Massless)?;
        self.couple(data, modes, known, bound, solved)
    }

    /// Solves for the normal loads, after the constraints and the mass matrix have been factorised.
    pub(super) fn couple(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        known: Option<&[f64]>,
        bound: bool,
        solved: &mut Solved,
    ) -> Result<(), Unsolved> {
        let Solved {
            coupled,
            balance,
            frictions,
            coupling_bound,
            coupling,
            efforts,
            sticking,
            workspace,
            load_tolerance,
            is_weak,
            ..
        } = solved;
        frictions.clear();
        let each = modes.iter().enumerate();
        frictions.extend(each.map(|(index, mode)| self.friction(data, index, *mode)));
        efforts.clear();
        efforts.extend(self.actuator_wrenches(data));
        if balance.has_passive_spins() {
            for &effort in &*efforts {
                balance
                    .check_passive_spins(self, data, Some(effort))
                    .map_err(Unsolved::Massless)?;
            }
            for (content, friction) in self.parameters.interfaces.iter().zip(&*frictions) {
                let parts = [friction.constant, friction.per_load];
                for part in parts.into_iter().filter(|part| *part != [0.0; 3]) {
                    let wrench = data.bodies.wrench_of(&self.topology, content, part);
                    let effort = Some((content.joint, wrench));
                    balance.check_passive_spins(self, data, effort).map_err(Unsolved::Massless)?;
                }
            }
        }
        coupling.update((self, data), frictions, efforts);
        *coupling_bound = None;
        if bound {
            coupling.need_influence((self, data), frictions, balance, sticking, workspace);
            *coupling_bound = Some(coupling.bound(self, data));
        }
        // The fixed-point iteration is used for mechanisms with a sparse factorisation and for weak
        // coupling. Otherwise, Newton's method with the influence matrix takes less time. If the
        // bound is one or more, other solutions may exist, and only Newton's method stays on the
        // present solution branch.
        let is_unique = !coupling_bound.is_some_and(|bound| bound >= 1.0);
        let iterates = is_unique && (balance.is_sparse() || *is_weak);
        let iterated = known.filter(|_| iterates).is_some_and(|known| {
            let results = (&mut *workspace, &mut *coupled);
            coupling.iterate((self, data), frictions, balance, (known, *load_tolerance), results)
        });
        if !iterated {
            coupling.need_influence((self, data), frictions, balance, sticking, workspace);
            coupling
                .solve((self, data), frictions, balance, known, (workspace, coupled))
                .map_err(Unsolved::Locked)?;
        }
        balance.keep_passive_spins(self, data, &mut coupled.response.accelerations);
        Ok(())
    }

    /// Searches for other solutions in the given modes, starting from many random normal loads.
    pub(super) fn others(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
        solved: &mut Solved,
    ) -> Vec<Competitor> {
        let Solved { coupled, balance, frictions, coupling, sticking, workspace, .. } = solved;
        coupling.need_influence((self, data), frictions, balance, sticking, workspace);
        let others = coupling.others((self, data), frictions, balance, coupled, workspace);
        let competitor = |other: Coupled| Competitor {
            loads: other.loads,
            accelerations: other.response.accelerations,
            interfaces: modes.to_vec(),
        };
        others.into_iter().map(competitor).collect()
    }

    /// Converts a failed solution into an error that names the joint or body.
    pub(super) fn unsolved(&self, time: f64, unsolved: Unsolved) -> ForwardError {
        match unsolved {
            Unsolved::Locked(Lock { part, interface }) => ForwardError::NoAcceleration {
                time,
                joint: self.joint_name(self.parameters.interfaces[interface].joint),
                percent: 100.0 * part,
            },
            Unsolved::Massless(Massless { body }) => {
                let body = self.simulated().bodies()[body].name.clone();
                ForwardError::Massless { time, body }
            }
        }
    }

    /// Returns the name of a joint of the simulated mechanism.
    pub(super) fn joint_name(&self, joint: usize) -> String {
        self.simulated().joints()[joint].name.clone()
    }
}
