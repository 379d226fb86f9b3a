//! Everything at one instant: accelerations, reactions, friction, powers.

use super::Forward;
use super::balance::{Balance, Scene};
use super::coupling::{Coupled, Coupling, Lost};
use super::error::{Competitor, ForwardError};
use super::inputs::{Inputs, View};
use super::masses::{Masses, exchange, potential};
use super::rows::{Held, Rows};
use super::rub::{
    Contact, Rub, bristle_rate, dissipated, law_of, load, norm, rub, surface_velocity, wrench_of,
};
use crate::dynamics::{AppliedLoad, Pull};
use crate::friction::OwnFriction;
use crate::kinematics::{Bodies, State, Target};
use crate::spatial::{Vec3, Wrench};
use crate::topology::Role;

/// A contact at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMoment {
    /// What it does.
    pub contact: Contact,
    /// Sliding velocity at the surface along its freedoms, m/s.
    pub velocity: [f64; 3],
    /// N.
    pub load: f64,
    /// Friction at the surface, with the sense of the sliding that it resists, N.
    pub friction: [f64; 3],
    /// The greatest friction before it slides, N; of a sliding contact that at rest under this load.
    pub limit: f64,
}

impl ContactMoment {
    /// By how much the limit is above the friction, N.
    pub fn margin(&self) -> f64 {
        self.limit - norm(self.friction)
    }
}

/// Powers of one instant, W, and energies, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// J.
    pub kinetic: f64,
    /// Gravity's (zero at the kernel origin) and springs', J.
    pub potential: f64,
    /// What potential energy grows by, W.
    pub exchange: f64,
    /// Power of each actuator, W.
    pub drives: Vec<f64>,
    /// Power of all loads, W.
    pub loads: f64,
    /// What dampers of springs dissipate, W.
    pub dampers: f64,
    /// What each contact dissipates, W; of bristles what they take up.
    pub contacts: Vec<f64>,
}

/// Everything at one instant.
#[derive(Clone, Debug)]
pub struct Instant {
    /// s.
    pub time: f64,
    /// Coordinates, rates, accelerations of the tree.
    pub state: State<f64>,
    /// Motion of all bodies, about the kernel origin.
    pub bodies: Bodies<f64>,
    /// Efforts of all actuators, N or N m.
    pub drives: Vec<f64>,
    /// For each joint the complete wrench that the predecessor exerts on the successor, world axes
    /// about the kernel origin.
    pub wrenches: Vec<Wrench<f64>>,
    /// All contacts.
    pub contacts: Vec<ContactMoment>,
    /// Rates of the deflections of bristles, m/s.
    pub(super) bristle_rates: Vec<[f64; 3]>,
    /// Energies and powers.
    pub account: Account,
    /// How strongly friction and reactions are coupled: below one there is no other solution. Only
    /// where it was asked for.
    pub coupling: Option<f64>,
    /// How many constraints, held freedoms among them, are redundant.
    pub redundant: usize,
    /// How many efforts of what is prescribed or locked are open: more are than it takes. Their sum of squares is
    /// least, rotary ones over the characteristic length.
    pub open_drives: usize,
    /// Degrees of freedom left.
    pub mobility: usize,
    /// How far the conditions are from being dependent: loops at a singular position.
    pub(super) distance: f64,
    /// A contact that sticks where its joint only stands for this instant, and must move an instant later.
    pub(super) gives_way: Option<usize>,
}

impl Instant {
    /// Force and moment, about the joint's origin (that of J), of each joint's complete wrench.
    pub fn reactions(&self) -> Vec<(Vec3<f64>, Vec3<f64>)> {
        let each = self.wrenches.iter().zip(&self.bodies.frame_j);
        each.map(|(w, j)| (w.force, w.moment_about(j.position))).collect()
    }
}

/// What is the same for all choices of sticking and sliding at one position and velocity.
pub(super) struct Ground {
    pub(super) time: f64,
    pub(super) state: State<f64>,
    pub(super) bodies: Bodies<f64>,
    pub(super) masses: Masses,
    pub(super) efforts: Vec<f64>,
    pub(super) loads: Vec<AppliedLoad<f64>>,
    pub(super) targets: Vec<Target<f64>>,
    pub(super) velocities: Vec<[f64; 3]>,
    pub(super) bristles: Vec<[f64; 3]>,
    /// The greatest friction of each contact, roughly: by it shares of friction are measured where they
    /// are not unique. They must not change while contacts do what they do.
    pub(super) grips: Vec<f64>,
    /// Frictions at the surface about which shares are least, N.
    pub(super) shares: Vec<[f64; 3]>,
    /// Friction that holds may exceed its limit by this factor; one but for rare moments.
    pub(super) overload: f64,
}

/// One choice, solved.
pub(super) struct Solved {
    pub(super) coupled: Coupled,
    pub(super) balance: Balance,
    pub(super) held: Vec<Held>,
    /// Which held freedoms belong to which contact: contact, place, index in `held`.
    pub(super) holding: Vec<(usize, usize, usize)>,
    pub(super) rubs: Vec<Rub>,
    pub(super) strength: Option<f64>,
}

/// Why a choice has no solution.
pub(super) enum Unsolved {
    Lost(Lost),
    /// The body that moves so.
    Massless(usize),
}

impl Forward {
    /// Positions, velocities and inputs of an instant.
    pub(super) fn ground(
        &self,
        time: f64,
        state: State<f64>,
        bristles: &[[f64; 3]],
        (grips, shares): (&[f64], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Ground {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let view =
            View { time, state: &state, bodies: &bodies, topology, pitch: &parameters.pitch };
        let mut efforts = vec![0.0; topology.actuators.len()];
        inputs.efforts(&view, &mut efforts);
        let mut loads = Vec::new();
        inputs.loads(&view, &mut loads);
        let targets = self.targets(time, inputs);
        for &actuator in &self.prescribed {
            efforts[actuator] = 0.0;
        }
        let masses = Masses::new(topology, parameters, &mut bodies, &loads);
        let contacts = parameters.contacts.iter();
        let velocities =
            contacts.map(|c| surface_velocity(topology, parameters, &bodies, c)).collect();
        let bristles = bristles.to_vec();
        let (grips, shares) = (grips.to_vec(), shares.to_vec());
        Ground {
            time,
            state,
            bodies,
            masses,
            efforts,
            loads,
            targets,
            velocities,
            bristles,
            grips,
            shares,
            overload: 1.0,
        }
    }

    pub(super) fn targets(&self, time: f64, inputs: &mut dyn Inputs) -> Vec<Target<f64>> {
        let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        let mut targets = vec![zero; self.prescribed.len()];
        inputs.targets(time, &mut targets);
        targets
    }

    pub(super) fn scene<'a>(&'a self, ground: &'a Ground) -> Scene<'a> {
        Scene {
            topology: &self.topology,
            parameters: &self.parameters,
            bodies: &ground.bodies,
            masses: &ground.masses,
            columns: &self.columns,
        }
    }

    /// The freedoms that are held when contacts do this.
    pub(super) fn held(
        &self,
        targets: &[Target<f64>],
        modes: &[Contact],
        grips: &[f64],
        shares: &[[f64; 3]],
    ) -> (Vec<Held>, Vec<(usize, usize, usize)>) {
        let mut held = Vec::new();
        for (&actuator, target) in self.prescribed.iter().zip(targets) {
            let actuator = self.topology.actuators[actuator];
            held.push(Held {
                joint: actuator.joint,
                freedom: actuator.freedom,
                acceleration: target.acceleration,
                drives: true,
                grip: 1.0,
                share: 0.0,
            });
        }
        let mut holding = Vec::new();
        for (index, (contact, mode)) in self.parameters.contacts.iter().zip(modes).enumerate() {
            if *mode != Contact::Sticks {
                continue;
            }
            for (place, freedom) in contact.shape.freedoms().enumerate() {
                let joint = contact.joint;
                let driven = held.iter().any(|h| (h.joint, h.freedom) == (joint, freedom));
                // What an actuator holds needs no friction.
                if !driven {
                    holding.push((index, place, held.len()));
                    let arm = contact.arms(self.parameters.pitch[joint])[place];
                    let grip = arm * grips.get(index).copied().unwrap_or(1.0);
                    let share = -arm * shares.get(index).map_or(0.0, |share| share[place]);
                    let drives = false;
                    held.push(Held { joint, freedom, acceleration: 0.0, drives, grip, share });
                }
            }
        }
        (held, holding)
    }

    /// Friction of all contacts, and the efforts of drives.
    pub(super) fn acting(
        &self,
        ground: &Ground,
        modes: &[Contact],
    ) -> (Vec<Rub>, Vec<(usize, Wrench<f64>)>) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let rubs = (0..modes.len()).map(|index| {
            let contact = &parameters.contacts[index];
            let pitch = parameters.pitch[contact.joint];
            let (velocity, deflection) = (ground.velocities[index], ground.bristles[index]);
            rub(contact, pitch, modes[index], velocity, deflection)
        });
        let mut efforts = Vec::new();
        for (actuator, effort) in topology.actuators.iter().zip(&ground.efforts) {
            if *effort != 0.0 {
                let freedom = &topology.joint_types[actuator.joint].freedoms()[actuator.freedom];
                let unit = ground.bodies.effort(freedom, actuator.joint);
                efforts.push((actuator.joint, unit * *effort));
            }
        }
        (rubs.collect(), efforts)
    }

    /// The wrenches of friction on joints, with one newton where the load makes it.
    fn rubbing<'r>(
        &'r self,
        ground: &'r Ground,
        rubs: &'r [Rub],
    ) -> impl Iterator<Item = (usize, Wrench<f64>)> + 'r {
        let each = self.parameters.contacts.iter().zip(rubs);
        each.flat_map(|(content, rub)| [(content, rub.known), (content, rub.per_load)])
            .filter(|(_, part)| *part != [0.0; 3])
            .map(|(content, part)| {
                (content.joint, wrench_of(&self.topology, &ground.bodies, content, part))
            })
    }

    /// Solves one choice; `known` are loads nearby. With `measure` also how strongly friction and loads
    /// are coupled.
    pub(super) fn solve(
        &self,
        ground: &Ground,
        modes: &[Contact],
        known: Option<&[f64]>,
        measure: bool,
    ) -> Result<Solved, Unsolved> {
        let scene = self.scene(ground);
        let (held, holding) = self.held(&ground.targets, modes, &ground.grips, &ground.shares);
        let rows = Rows::new(&self.topology, &self.parameters, &ground.bodies, &held);
        let balance = Balance::new(&scene, rows).map_err(|m| Unsolved::Massless(m.body))?;
        let (rubs, efforts) = self.acting(ground, modes);
        let pushes = efforts.iter().copied().chain(self.rubbing(ground, &rubs));
        for push in pushes {
            balance.pushed(&scene, Some(push)).map_err(|m| Unsolved::Massless(m.body))?;
        }
        let coupling = Coupling::new(scene, &balance, &rubs, &efforts);
        let strength = measure.then(|| coupling.strength());
        let mut coupled = coupling.solve(known).map_err(Unsolved::Lost)?;
        balance.keep_spins(&self.scene(ground), &mut coupled.response.accelerations);
        Ok(Solved { coupled, balance, held, holding, rubs, strength })
    }

    /// Other solutions of the same choice than the given one, as far as they are found.
    pub(super) fn others(
        &self,
        ground: &Ground,
        modes: &[Contact],
        solved: &Solved,
    ) -> Vec<Competitor> {
        let (rubs, efforts) = self.acting(ground, modes);
        let coupling = Coupling::new(self.scene(ground), &solved.balance, &rubs, &efforts);
        let others = coupling.others(&solved.coupled).into_iter().map(|other| Competitor {
            loads: other.loads,
            accelerations: other.response.accelerations,
            contacts: modes.to_vec(),
        });
        others.collect()
    }

    /// The friction at the surface and the load of each contact of a solved choice.
    pub(super) fn contacts(
        &self,
        ground: &Ground,
        modes: &[Contact],
        solved: &Solved,
    ) -> Vec<ContactMoment> {
        let parameters = &self.parameters;
        let mut moments = Vec::with_capacity(modes.len());
        for (index, contact) in parameters.contacts.iter().enumerate() {
            let arms = contact.arms(parameters.pitch[contact.joint]);
            let mut load_now = solved.coupled.loads[index];
            let mut friction = [0.0; 3];
            if modes[index] == Contact::Sticks {
                for &(of, place, row) in &solved.holding {
                    if of == index {
                        let first = self.topology.constraints;
                        let effort = solved.coupled.response.multipliers[first + row];
                        friction[place] = -effort / arms[place];
                    }
                }
                let own = OwnFriction {
                    coefficient: 0.0,
                    viscous: friction[0].abs(),
                    direction: friction[0].signum(),
                };
                let wrench = solved.coupled.response.wrenches[contact.joint];
                load_now = load(parameters, &ground.bodies, contact, own, wrench).value;
            } else {
                let rub = &solved.rubs[index];
                for place in 0..contact.shape.freedoms().len() {
                    let effort = rub.known[place] + rub.per_load[place] * load_now;
                    friction[place] = effort / arms[place];
                }
            }
            let limit = law_of(contact, friction[0]).at_rest() * load_now;
            let (mut velocity, mode) = (ground.velocities[index], modes[index]);
            if mode == Contact::Sticks && self.leaders(index).is_none() {
                // What others that stick leave of it is rounding.
                velocity = [0.0; 3];
            }
            moments.push(ContactMoment {
                contact: mode,
                velocity,
                load: load_now,
                friction,
                limit,
            });
        }
        moments
    }

    /// Everything of a solved choice.
    pub(super) fn instant(&self, ground: Ground, modes: &[Contact], solved: &Solved) -> Instant {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let contacts = self.contacts(&ground, modes, solved);
        let gives_way = self.gives_way(&ground, solved).map(|(contact, _)| contact);
        let Ground { time, mut state, mut bodies, masses, efforts, loads, bristles, .. } = ground;
        state.accelerations.clone_from(&solved.coupled.response.accelerations);
        for held in &solved.held {
            if let Role::Tree { node } = topology.role[held.joint] {
                // Not to rounding, but exactly: what is held does not drift.
                let dof = topology.nodes[node].dofs.start + held.freedom;
                state.accelerations[dof] = held.acceleration;
            }
        }
        bodies.accelerate(topology, &state.accelerations);
        let mut drives = efforts;
        for (k, &actuator) in self.prescribed.iter().enumerate() {
            drives[actuator] = solved.coupled.response.multipliers[topology.constraints + k];
        }
        let power_of = |actuator: usize| {
            let at = topology.actuators[actuator];
            drives[actuator] * bodies.joint_rates(topology, at.joint)[at.freedom]
        };
        let damper = |spring: &crate::parameters::SpringParameters<f64>| {
            let rate = Pull::of(spring, &bodies).rate;
            spring.damping * rate * rate
        };
        let account = Account {
            kinetic: masses.kinetic(&bodies),
            potential: potential(parameters, &bodies),
            exchange: exchange(parameters, &bodies),
            drives: (0..drives.len()).map(power_of).collect(),
            loads: loads.iter().map(|l| bodies.twist[l.body.0].power(l.wrench(&bodies))).sum(),
            dampers: parameters.springs.iter().map(damper).sum(),
            contacts: contacts.iter().map(dissipated).collect(),
        };
        let bristle_rates = parameters
            .contacts
            .iter()
            .zip(&contacts)
            .zip(&bristles)
            .map(|((contact, moment), z)| bristle_rate(contact, moment.velocity, *z))
            .collect();
        Instant {
            time,
            state,
            bodies,
            drives,
            wrenches: solved.coupled.response.wrenches.clone(),
            contacts,
            bristle_rates,
            account,
            coupling: solved.strength,
            redundant: solved.balance.spread.stresses.len(),
            open_drives: solved.balance.spread.open_drives(),
            mobility: solved.balance.mobility(topology.freedoms()),
            distance: solved.balance.distance(),
            gives_way,
        }
    }

    pub(super) fn unsolved(&self, time: f64, unsolved: Unsolved) -> ForwardError {
        match unsolved {
            Unsolved::Lost(Lost { part, contact }) => ForwardError::NoAcceleration {
                time,
                joint: self.joint_name(self.parameters.contacts[contact].joint),
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
