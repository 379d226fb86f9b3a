//! Everything at one instant: accelerations, reactions, friction, powers.

use super::Forward;
use super::balance::{Balance, Scene, Scratch};
use super::coupling::{Coupled, Coupling, Lost, Site};
use super::error::{Competitor, ForwardError};
use super::inputs::{Inputs, View};
use super::masses::{Masses, exchange, potential};
use super::rows::Held;
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
    /// What is no number in it, if anything is.
    pub(super) fn unfinite(&self) -> Option<&'static str> {
        if !self.state.accelerations.iter().all(|a| a.is_finite()) {
            return Some("an acceleration");
        }
        // Magnitudes are told, too: squares must not be infinite.
        let is_finite = |w: &Wrench<f64>| [w.force, w.moment].iter().all(|v| v.dot(*v).is_finite());
        (!self.wrenches.iter().all(is_finite)).then_some("a reaction")
    }

    /// Room for an instant.
    pub(super) fn new(model: &Forward) -> Self {
        let topology = &model.topology;
        Self {
            time: 0.0,
            state: State::new(topology),
            bodies: Bodies::new(topology),
            drives: Vec::new(),
            wrenches: Vec::new(),
            contacts: Vec::new(),
            bristle_rates: Vec::new(),
            account: Account::default(),
            coupling: None,
            redundant: 0,
            mobility: 0,
            distance: 0.0,
            open_drives: 0,
            gives_way: None,
        }
    }

    /// Force and moment, about the joint's origin (that of J), of each joint's complete wrench.
    pub fn reactions(&self) -> Vec<(Vec3<f64>, Vec3<f64>)> {
        let each = self.wrenches.iter().zip(&self.bodies.frame_j);
        each.map(|(w, j)| (w.force, w.moment_about(j.position))).collect()
    }
}

/// What is the same for all choices of sticking and sliding at one position and velocity.
#[derive(Clone, Debug)]
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

impl Ground {
    /// Room for it.
    pub(super) fn new(model: &Forward) -> Self {
        Self {
            time: 0.0,
            state: State::new(&model.topology),
            bodies: Bodies::new(&model.topology),
            masses: Masses::default(),
            efforts: Vec::new(),
            loads: Vec::new(),
            targets: Vec::new(),
            velocities: Vec::new(),
            bristles: Vec::new(),
            grips: Vec::new(),
            shares: Vec::new(),
            overload: 1.0,
        }
    }
}

/// One choice, solved.
#[derive(Clone, Debug, Default)]
pub(super) struct Solved {
    pub(super) coupled: Coupled,
    pub(super) balance: Balance,
    pub(super) held: Vec<Held>,
    /// Which held freedoms belong to which contact: contact, place, index in `held`.
    pub(super) holding: Vec<(usize, usize, usize)>,
    pub(super) rubs: Vec<Rub>,
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
    /// Positions, velocities and inputs of an instant.
    pub(super) fn ground(
        &self,
        time: f64,
        state: State<f64>,
        bristles: &[[f64; 3]],
        (grips, shares): (&[f64], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Ground {
        let mut ground = Ground { time, state, ..Ground::new(self) };
        ground.bristles.extend_from_slice(bristles);
        ground.grips.extend_from_slice(grips);
        ground.shares.extend_from_slice(shares);
        self.look(&mut ground, inputs);
        ground
    }

    /// The same in the room that is there, where time, state, bristles, grips and shares are.
    pub(super) fn look(&self, ground: &mut Ground, inputs: &mut dyn Inputs) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Ground { time, state, bodies, masses, efforts, loads, targets, velocities, .. } =
            ground;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
        let pitch = &parameters.pitch;
        let view = View { time: *time, state, bodies, topology, pitch, angles: &[] };
        efforts.clear();
        efforts.resize(topology.actuators.len(), 0.0);
        inputs.efforts(&view, efforts);
        loads.clear();
        inputs.loads(&view, loads);
        self.targets_into(*time, inputs, targets);
        for &actuator in &self.prescribed {
            efforts[actuator] = 0.0;
        }
        masses.update(topology, parameters, bodies, loads);
        velocities.clear();
        let contacts = parameters.contacts.iter();
        velocities.extend(contacts.map(|c| surface_velocity(topology, parameters, bodies, c)));
        ground.overload = 1.0;
    }

    pub(super) fn targets(&self, time: f64, inputs: &mut dyn Inputs) -> Vec<Target<f64>> {
        let mut targets = Vec::new();
        self.targets_into(time, inputs, &mut targets);
        targets
    }

    pub(super) fn targets_into(
        &self,
        time: f64,
        inputs: &mut dyn Inputs,
        targets: &mut Vec<Target<f64>>,
    ) {
        let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        targets.clear();
        targets.resize(self.prescribed.len(), zero);
        inputs.targets(time, targets);
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
        let (mut held, mut holding) = (Vec::new(), Vec::new());
        self.held_into(targets, modes, (grips, shares), &mut held, &mut holding);
        (held, holding)
    }

    /// The same in the room that is there.
    pub(super) fn held_into(
        &self,
        targets: &[Target<f64>],
        modes: &[Contact],
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
                freedom: actuator.freedom,
                acceleration: target.acceleration,
                drives: true,
                grip: 1.0,
                share: 0.0,
            });
        }
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
    }

    /// Friction of all contacts, and the efforts of drives.
    pub(super) fn acting(
        &self,
        ground: &Ground,
        modes: &[Contact],
    ) -> (Vec<Rub>, Vec<(usize, Wrench<f64>)>) {
        let (mut rubs, mut efforts) = (Vec::new(), Vec::new());
        self.acting_into(ground, modes, &mut rubs, &mut efforts);
        (rubs, efforts)
    }

    /// The same in the room that is there.
    fn acting_into(
        &self,
        ground: &Ground,
        modes: &[Contact],
        rubs: &mut Vec<Rub>,
        efforts: &mut Vec<(usize, Wrench<f64>)>,
    ) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        rubs.clear();
        rubs.extend((0..modes.len()).map(|index| {
            let contact = &parameters.contacts[index];
            let pitch = parameters.pitch[contact.joint];
            let (velocity, deflection) = (ground.velocities[index], ground.bristles[index]);
            rub(contact, pitch, modes[index], velocity, deflection)
        }));
        efforts.clear();
        for (actuator, effort) in topology.actuators.iter().zip(&ground.efforts) {
            if *effort != 0.0 {
                let freedom = &topology.joint_types[actuator.joint].freedoms()[actuator.freedom];
                let unit = ground.bodies.effort(freedom, actuator.joint);
                efforts.push((actuator.joint, unit * *effort));
            }
        }
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
        let mut solved = Solved::default();
        self.solve_into(ground, modes, known, measure, &mut solved)?;
        Ok(solved)
    }

    /// The same in the room that is there.
    pub(super) fn solve_into(
        &self,
        ground: &Ground,
        modes: &[Contact],
        known: Option<&[f64]>,
        measure: bool,
        solved: &mut Solved,
    ) -> Result<(), Unsolved> {
        let scene = self.scene(ground);
        let Solved { balance, held, holding, scratch, .. } = solved;
        let measures = (&ground.grips[..], &ground.shares[..]);
        self.held_into(&ground.targets, modes, measures, held, holding);
        balance.rows.update(&self.topology, &self.parameters, &ground.bodies, held);
        balance.update(&scene, scratch).map_err(|m| Unsolved::Massless(m.body))?;
        self.couple(ground, modes, known, measure, solved)
    }

    /// Solves it where conditions and masses are what they were.
    pub(super) fn couple(
        &self,
        ground: &Ground,
        modes: &[Contact],
        known: Option<&[f64]>,
        measure: bool,
        solved: &mut Solved,
    ) -> Result<(), Unsolved> {
        let Solved { coupled, balance, rubs, strength, coupling, efforts, scratch, .. } = solved;
        self.acting_into(ground, modes, rubs, efforts);
        if balance.has_idle() {
            let pushes = efforts.iter().copied().chain(self.rubbing(ground, rubs));
            for push in pushes {
                balance
                    .pushed(&self.scene(ground), Some(push))
                    .map_err(|m| Unsolved::Massless(m.body))?;
            }
        }
        let site = Site { scene: self.scene(ground), rubs };
        coupling.update(site, balance, efforts, scratch);
        *strength = measure.then(|| coupling.strength(site));
        coupling.solve(site, balance, known, scratch, coupled).map_err(Unsolved::Lost)?;
        balance.keep_spins(&self.scene(ground), &mut coupled.response.accelerations);
        Ok(())
    }

    /// Other solutions of the same choice than the given one, as far as they are found.
    pub(super) fn others(
        &self,
        ground: &Ground,
        modes: &[Contact],
        solved: &mut Solved,
    ) -> Vec<Competitor> {
        let Solved { coupled, balance, rubs, coupling, scratch, .. } = solved;
        let site = Site { scene: self.scene(ground), rubs };
        let others =
            coupling.others(site, balance, coupled, scratch).into_iter().map(|other| Competitor {
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
        let mut moments = Vec::with_capacity(modes.len());
        self.contacts_into(ground, modes, solved, &mut moments);
        moments
    }

    /// The same in the room that is there.
    fn contacts_into(
        &self,
        ground: &Ground,
        modes: &[Contact],
        solved: &Solved,
        moments: &mut Vec<ContactMoment>,
    ) {
        let parameters = &self.parameters;
        moments.clear();
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
    }

    /// Everything of a solved choice.
    pub(super) fn instant(&self, ground: Ground, modes: &[Contact], solved: &Solved) -> Instant {
        let mut instant = Instant::new(self);
        self.instant_into(&ground, modes, solved, &mut instant);
        instant
    }

    /// The same in the room that is there.
    pub(super) fn instant_into(
        &self,
        ground: &Ground,
        modes: &[Contact],
        solved: &Solved,
        instant: &mut Instant,
    ) {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let Ground { efforts, loads, masses, .. } = ground;
        let Instant { state, bodies, drives, wrenches, contacts, bristle_rates, account, .. } =
            instant;
        self.contacts_into(ground, modes, solved, contacts);
        state.clone_from(&ground.state);
        bodies.clone_from(&ground.bodies);
        let response = &solved.coupled.response;
        state.accelerations.clone_from(&response.accelerations);
        for held in &solved.held {
            if let Role::Tree { node } = topology.role[held.joint] {
                // Not to rounding, but exactly: what is held does not drift.
                let dof = topology.nodes[node].dofs.start + held.freedom;
                state.accelerations[dof] = held.acceleration;
            }
        }
        bodies.accelerate(topology, &state.accelerations);
        drives.clone_from(efforts);
        for (k, &actuator) in self.prescribed.iter().enumerate() {
            drives[actuator] = response.multipliers[topology.constraints + k];
        }
        let power_of = |actuator: usize| {
            let at = topology.actuators[actuator];
            drives[actuator] * bodies.joint_rates(topology, at.joint)[at.freedom]
        };
        let damper = |spring: &crate::parameters::SpringParameters<f64>| {
            let rate = Pull::of(spring, bodies).rate;
            spring.damping * rate * rate
        };
        account.kinetic = masses.kinetic(bodies);
        account.potential = potential(parameters, bodies);
        account.exchange = exchange(parameters, bodies);
        account.drives.clear();
        account.drives.extend((0..drives.len()).map(power_of));
        account.loads = loads.iter().map(|l| bodies.twist[l.body.0].power(l.wrench(bodies))).sum();
        account.dampers = parameters.springs.iter().map(damper).sum();
        account.contacts.clear();
        account.contacts.extend(contacts.iter().map(dissipated));
        bristle_rates.clear();
        let moments = parameters.contacts.iter().zip(&*contacts).zip(&ground.bristles);
        bristle_rates.extend(
            moments.map(|((contact, moment), z)| bristle_rate(contact, moment.velocity, *z)),
        );
        wrenches.clone_from(&response.wrenches);
        instant.time = ground.time;
        instant.coupling = solved.strength;
        instant.redundant = solved.balance.spread.stresses.len();
        instant.open_drives = solved.balance.spread.open_drives();
        instant.mobility = solved.balance.mobility(topology.freedoms());
        instant.distance = solved.balance.distance();
        instant.gives_way = self.gives_way(ground, solved).map(|(contact, _)| contact);
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
