//! One choice of what sticks and what slides, solved: accelerations and reactions with friction.

use super::Forward;
use super::affine_friction::{AffineFriction, InterfaceMode, rub};
use super::balance::{Balance, Scratch};
use super::constraint_jacobian::Held;
use super::coupling::{Coupled, Coupling, Lost, Site};
use super::error::{Competitor, ForwardError};
use super::situation::Situation;
use crate::kinematics::Target;
use crate::spatial::Wrench;

/// One choice, solved.
#[derive(Clone, Debug, Default)]
pub(super) struct Solved {
    pub(super) coupled: Coupled,
    pub(super) balance: Balance,
    pub(super) held: Vec<Held>,
    /// Which held freedoms belong to which contact: contact, place, index in `held`.
    pub(super) holding: Vec<(usize, usize, usize)>,
    pub(super) affine_frictions: Vec<AffineFriction>,
    pub(super) strength: Option<f64>,
    coupling: Coupling,
    efforts: Vec<(usize, Wrench<f64>)>,
    scratch: Scratch,
}

/// Why a choice has no solution.
pub(super) enum Unsolved {
    Lost(Lost),
    /// The body that moves so.
    Massless(usize),
}

impl Forward {
    /// The freedoms that are held when contacts do this.
    pub(super) fn held(
        &self,
        targets: &[Target<f64>],
        modes: &[InterfaceMode],
        grips: &[f64],
        shares: &[[f64; 3]],
    ) -> (Vec<Held>, Vec<(usize, usize, usize)>) {
        let (mut held, mut holding) = (Vec::new(), Vec::new());
        self.held_into(targets, modes, (grips, shares), &mut held, &mut holding);
        (held, holding)
    }

    /// The same in the room that is there.
    pub(super) fn held_into(
        &self,
        targets: &[Target<f64>],
        modes: &[InterfaceMode],
        (grips, shares): (&[f64], &[[f64; 3]]),
        held: &mut Vec<Held>,
        holding: &mut Vec<(usize, usize, usize)>,
    ) {
        held.clear();
        holding.clear();
        for (&actuator, target) in self.prescribed.iter().zip(targets) {
            let actuator = self.topology.actuators[actuator];
            held.push(Held {
                joint: actuator.joint,
                dof: actuator.dof,
                acceleration: target.acceleration,
                drives: true,
                grip: 1.0,
                share: 0.0,
            });
        }
        for (index, (interface, mode)) in self.parameters.interfaces.iter().zip(modes).enumerate() {
            if *mode != InterfaceMode::Sticks {
                continue;
            }
            for (place, dof) in interface.shape.dofs().enumerate() {
                let joint = interface.joint;
                let driven = held.iter().any(|h| (h.joint, h.dof) == (joint, dof));
                // What an actuator holds needs no friction.
                if !driven {
                    holding.push((index, place, held.len()));
                    let arm = interface.arms(self.parameters.pitch[joint])[place];
                    let grip = arm * grips.get(index).copied().unwrap_or(1.0);
                    let share = -arm * shares.get(index).map_or(0.0, |share| share[place]);
                    let drives = false;
                    held.push(Held { joint, dof, acceleration: 0.0, drives, grip, share });
                }
            }
        }
    }

    /// Friction of all contacts, and the efforts of drives.
    pub(super) fn acting(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
    ) -> (Vec<AffineFriction>, Vec<(usize, Wrench<f64>)>) {
        let (mut affine_frictions, mut efforts) = (Vec::new(), Vec::new());
        self.acting_into(situation, modes, &mut affine_frictions, &mut efforts);
        (affine_frictions, efforts)
    }

    /// The same in the room that is there.
    fn acting_into(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        affine_frictions: &mut Vec<AffineFriction>,
        efforts: &mut Vec<(usize, Wrench<f64>)>,
    ) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        affine_frictions.clear();
        affine_frictions.extend((0..modes.len()).map(|index| {
            let interface = &parameters.interfaces[index];
            let pitch = parameters.pitch[interface.joint];
            let (velocity, deflection) = (situation.velocities[index], situation.bristles[index]);
            rub(interface, pitch, modes[index], velocity, deflection)
        }));
        efforts.clear();
        for (actuator, effort) in topology.actuators.iter().zip(&situation.efforts) {
            if *effort != 0.0 {
                let dof = &topology.joint_types[actuator.joint].dofs()[actuator.dof];
                let unit = situation.bodies.effort(dof, actuator.joint);
                efforts.push((actuator.joint, unit * *effort));
            }
        }
    }

    /// The wrenches of friction on joints, with one newton where the load makes it.
    fn rubbing<'r>(
        &'r self,
        situation: &'r Situation,
        affine_frictions: &'r [AffineFriction],
    ) -> impl Iterator<Item = (usize, Wrench<f64>)> + 'r {
        let each = self.parameters.interfaces.iter().zip(affine_frictions);
        each.flat_map(|(content, rub)| [(content, rub.known), (content, rub.per_load)])
            .filter(|(_, part)| *part != [0.0; 3])
            .map(|(content, part)| {
                (content.joint, situation.bodies.wrench_of(&self.topology, content, part))
            })
    }

    /// Solves one choice; `known` are loads nearby. With `measure` also how strongly friction and loads
    /// are coupled.
    pub(super) fn solve(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        known: Option<&[f64]>,
        measure: bool,
    ) -> Result<Solved, Unsolved> {
        let mut solved = Solved::default();
        self.solve_into(situation, modes, known, measure, &mut solved)?;
        Ok(solved)
    }

    /// The same in the room that is there.
    pub(super) fn solve_into(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        known: Option<&[f64]>,
        measure: bool,
        solved: &mut Solved,
    ) -> Result<(), Unsolved> {
        let scene = self.scene(situation);
        let Solved { balance, held, holding, scratch, .. } = solved;
        let measures = (&situation.grips[..], &situation.shares[..]);
        self.held_into(&situation.targets, modes, measures, held, holding);
        balance.rows.update(&self.topology, &self.parameters, &situation.bodies, held);
        balance.update(&scene, scratch).map_err(|m| Unsolved::Massless(m.body))?;
        self.couple(situation, modes, known, measure, solved)
    }

    /// Solves it where conditions and masses are what they were.
    pub(super) fn couple(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        known: Option<&[f64]>,
        measure: bool,
        solved: &mut Solved,
    ) -> Result<(), Unsolved> {
        let Solved {
            coupled, balance, affine_frictions, strength, coupling, efforts, scratch, ..
        } = solved;
        self.acting_into(situation, modes, affine_frictions, efforts);
        if balance.has_idle() {
            let pushes = efforts.iter().copied().chain(self.rubbing(situation, affine_frictions));
            for push in pushes {
                balance
                    .pushed(&self.scene(situation), Some(push))
                    .map_err(|m| Unsolved::Massless(m.body))?;
            }
        }
        let site = Site { scene: self.scene(situation), affine_frictions };
        coupling.update(site, balance, efforts, scratch);
        *strength = measure.then(|| coupling.strength(site));
        coupling.solve(site, balance, known, scratch, coupled).map_err(Unsolved::Lost)?;
        balance.keep_spins(&self.scene(situation), &mut coupled.response.accelerations);
        Ok(())
    }

    /// Other solutions of the same choice than the given one, as far as they are found.
    pub(super) fn others(
        &self,
        situation: &Situation,
        modes: &[InterfaceMode],
        solved: &mut Solved,
    ) -> Vec<Competitor> {
        let Solved { coupled, balance, affine_frictions, coupling, scratch, .. } = solved;
        let site = Site { scene: self.scene(situation), affine_frictions };
        let others =
            coupling.others(site, balance, coupled, scratch).into_iter().map(|other| Competitor {
                loads: other.loads,
                accelerations: other.response.accelerations,
                interfaces: modes.to_vec(),
            });
        others.collect()
    }

    pub(super) fn unsolved(&self, time: f64, unsolved: Unsolved) -> ForwardError {
        match unsolved {
            Unsolved::Lost(Lost { part, interface }) => ForwardError::NoAcceleration {
                time,
                joint: self.joint_name(self.parameters.interfaces[interface].joint),
                percent: 100.0 * part,
            },
            Unsolved::Massless(body) => {
                let body = self.mechanism.bodies()[body].name.clone();
                ForwardError::Massless { time, body }
            }
        }
    }

    pub(super) fn joint_name(&self, joint: usize) -> String {
        self.mechanism.joints()[joint].name.clone()
    }
}
