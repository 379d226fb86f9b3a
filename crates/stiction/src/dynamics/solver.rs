//! Inverse dynamics in `f64` with every check: the library's front door.
//!
//! Equation (F9) of the book's theory.

use super::bounds;
use super::careful;
use super::contacts::ContactState;
use super::coupling::CouplingRoom;
use super::error::InverseError;
use super::forces::Forces;
use super::inverse::{FrictionMode, Inverse, Settings, Setup};
use super::kernel::Kernel;
use super::load::AppliedLoad;
use super::newton_euler::NewtonEuler;
use super::plan::{BalancePlan, NotPlanned};
use super::power::Power;
use super::rest::{self, Rest};
use super::shares::{Shares, Sharing};
use super::spring::Pull;
use super::structure::Weighting;
use super::wedge::{self, Lock};
use crate::friction::ContactShape;
use crate::kinematics::{
    Assembly, AssemblyError, Bodies, Coordinate, Kinematics, Target, actuator_rate, body_twists,
};
use crate::linalg::Elimination;
use crate::mechanism::{BodyId, JointId, Mechanism};
use crate::mobility::{DETERMINED, IdleAxis, Statics, Uncarried};
use crate::parameters::{ContactParameters, Parameters};
use crate::spatial::{Mat3, Pose};
use crate::topology::{Topology, TreeRule};
use nalgebra::DMatrix;

/// Forces are given out only where the power balance holds to this part of what is turned over.
/// Round-off is some 1e-15; positions near singular ones magnify it.
const BALANCED: f64 = 1e-9;

/// Moves a mechanism and computes all its forces.
///
/// ```
/// use stiction::dynamics::{InverseDynamics, Settings};
/// use stiction::joint::JointType;
/// use stiction::kinematics::{Coordinate, Target};
/// use stiction::mechanism::{BodySpec, JointId, JointSpec, MechanismBuilder};
/// use stiction::spatial::Vec3;
///
/// let pendulum = MechanismBuilder::new("pendulum")
///     .gravity(Vec3::new(0.0, -9.81, 0.0))
///     .body(BodySpec::new("bob").mass(2.0).com(Vec3::new(0.5, 0.0, 0.0)))
///     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
///     .build()
///     .map_err(|defects| defects[0].clone())?;
/// let angle = Coordinate::Joint { joint: JointId(0), freedom: 0 };
/// let level = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
/// let mut solver =
///     InverseDynamics::new(pendulum, &[], &[angle], &[level], Settings::default())?;
/// // Held level, it weighs 2 kg * 9.81 m/s^2 at half a metre.
/// assert!((solver.solve(&[])?.drives[0] - 9.81).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct InverseDynamics {
    mechanism: Mechanism,
    topology: Topology,
    parameters: Parameters<f64>,
    assembly: Assembly,
    settings: Settings,
    plan: Result<BalancePlan, NotPlanned>,
    inverse: Option<Inverse<f64>>,
    /// By which rates were solved for first: whatever is planned later, its signs compare.
    first_program: Elimination,
    forces: Forces,
    /// The strength of the coupling in the last solution by the kernel.
    strength: f64,
    room: CouplingRoom,
    /// Made when it is first asked for.
    sharing: Option<Sharing<f64>>,
    /// Whether the last forces are those of the kernel, and not of the dense system.
    forces_by_kernel: bool,
    shares: Shares<f64>,
    /// How often the balance was planned.
    plans: u64,
}

/// The motion of a solver the other way, at position after position: see [`InverseDynamics::reversed`].
/// Most of what a copy consists of stays the same along a motion and is copied once.
#[derive(Clone, Debug, Default)]
pub struct Mirror {
    copy: Option<InverseDynamics>,
    /// The plans of the original and of the copy when they were the same.
    plans: [(u64, u64); 2],
}

impl Mirror {
    /// The same as [`InverseDynamics::reversed`] of `solver`, which must be the same one every time, but for
    /// the forces of the last solution.
    pub fn of(&mut self, solver: &InverseDynamics) -> &mut InverseDynamics {
        let plans = |solver: &InverseDynamics| (solver.plans, solver.assembly.plans());
        let kept = self.copy.take().filter(|copy| self.plans == [plans(solver), plans(copy)]);
        let mut copy = kept.unwrap_or_else(|| solver.clone());
        self.plans = [plans(solver), plans(&copy)];
        copy.settings = solver.settings;
        copy.assembly.go_to(&solver.assembly);
        copy.assembly.reverse(&copy.topology, &copy.parameters);
        self.copy.insert(copy)
    }
}

/// What the kernel works with.
pub(super) struct Parts<'a> {
    pub(super) setup: Setup<'a>,
    pub(super) inverse: &'a Inverse<f64>,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) kinematics: &'a mut Kinematics<f64>,
    pub(super) settings: &'a Settings,
}

impl InverseDynamics {
    /// Assembles the mechanism at `targets`, one for each of `coordinates`. `homes` are guesses of
    /// the poses of bodies in the ground's frame.
    ///
    /// # Errors
    /// See [`AssemblyError`].
    pub fn new(
        mechanism: Mechanism,
        homes: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
        settings: Settings,
    ) -> Result<Self, AssemblyError> {
        let rule = TreeRule::Structure;
        Self::with_tree(mechanism, rule, homes, coordinates, targets, settings)
    }

    /// The same with a tree chosen by `rule`.
    ///
    /// # Errors
    /// See [`AssemblyError`].
    pub fn with_tree(
        mechanism: Mechanism,
        rule: TreeRule,
        homes: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
        settings: Settings,
    ) -> Result<Self, AssemblyError> {
        let topology = Topology::with_tree(&mechanism, rule);
        let parameters = Parameters::new(&mechanism);
        let assembly =
            Assembly::new(&mechanism, &topology, &parameters, homes, coordinates, targets)?;
        let forces = Forces::new(
            topology.actuators.len(),
            mechanism.joints().len(),
            parameters.contacts.len(),
        );
        let first_program = assembly.program().clone();
        let shares = Shares::new(topology.actuators.len(), parameters.contacts.len());
        let mut solver = Self {
            mechanism,
            topology,
            parameters,
            assembly,
            settings,
            plan: Err(NotPlanned::Singular),
            inverse: None,
            first_program,
            forces,
            strength: 0.0,
            room: CouplingRoom::default(),
            sharing: None,
            forces_by_kernel: true,
            shares,
            plans: 0,
        };
        solver.replan();
        Ok(solver)
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// The graph.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The numbers.
    pub fn parameters(&self) -> &Parameters<f64> {
        &self.parameters
    }

    /// What is computed, and how accurately.
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// The position and its derivatives as assembled.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Motion of all bodies; accelerations of idle spins are those of the last [`Self::solve`].
    pub fn bodies(&self) -> &Bodies<f64> {
        &self.assembly.kinematics().bodies
    }

    /// How strongly friction and reactions are coupled where the last [`Self::solve`] was: below one
    /// there is no other solution than the one it found; above, there may be, and it found the one
    /// that is connected with no friction. Zero without friction or where it is not coupled. None
    /// where the position is singular, or constraints and actuators are both redundant.
    pub fn coupling(&self) -> Option<f64> {
        if self.settings.friction != FrictionMode::Converged || self.parameters.contacts.is_empty()
        {
            return Some(0.0);
        }
        // Of the last solution by the kernel; the dense path does not know it.
        let strength = if self.forces_by_kernel { self.strength } else { f64::INFINITY };
        strength.is_finite().then_some(strength)
    }

    /// The kernel's parts at the present position; none where it is singular, or redundant in
    /// constraints and actuators at once.
    pub(super) fn parts(&mut self) -> Option<Parts<'_>> {
        let (Ok(balance), Some(inverse)) = (&self.plan, &self.inverse) else { return None };
        let (topology, parameters, settings) = (&self.topology, &self.parameters, &self.settings);
        let (prescription, motion, kinematics) = self.assembly.parts();
        let setup = Setup { topology, prescription, motion, balance };
        Some(Parts { setup, inverse, parameters, kinematics, settings })
    }

    /// On which side of the singular positions of its actuators the mechanism is: the sign of the
    /// determinant of closures and actuators by the freedoms of the tree, up to a constant. It
    /// vanishes where something can move while all actuators stand still. None unless there are as
    /// many actuators as prescribed coordinates.
    pub fn side(&mut self) -> Option<f64> {
        let topology = &self.topology;
        let freedoms = topology.freedoms();
        let (prescription, motion, kinematics) = self.assembly.parts();
        let count = prescription.coordinates().len();
        if count == 0 || count != topology.actuators.len() {
            return None;
        }
        // Where just the actuators are prescribed the matrix is a permutation.
        if let Some(sign) = order_of_actuators(topology, prescription.coordinates()) {
            return Some(sign * kinematics.sign_by(&self.first_program)?.signum());
        }
        let mut rates = vec![0.0; freedoms];
        let mut matrix = DMatrix::zeros(count, count);
        for column in 0..count {
            kinematics.response_to_coordinate(prescription, motion, column, &mut rates);
            let bodies = &kinematics.bodies;
            let twists = body_twists(topology, bodies, &rates);
            for (row, actuator) in topology.actuators.iter().enumerate() {
                matrix[(row, column)] = actuator_rate(topology, bodies, actuator, &twists);
            }
        }
        // Closures and actuators by the tree are these times closures and coordinates by the tree.
        let prescription = kinematics.sign_by(&self.first_program)?;
        let determinant = matrix.determinant() * prescription;
        determinant.is_finite().then(|| determinant.signum())
    }

    /// Where bodies spin idly: each body's index and the axis of its spin in world axes.
    pub fn idle_axes(&self) -> Vec<IdleAxis> {
        let spins = self.assembly.prescription().spins().iter();
        let pose = &self.bodies().pose;
        spins.map(|spin| (spin.body.0, pose[spin.body.0].rotation * spin.axis)).collect()
    }

    /// The scalar coordinates of a joint, m and rad, angles within half a turn; nothing for joints
    /// that turn in all directions.
    pub fn joint_coordinates(&self, joint: JointId) -> Vec<f64> {
        let content = &self.mechanism.joints()[joint.0];
        if !content.joint_type.has_scalar_coordinates() {
            return Vec::new();
        }
        let bodies = self.bodies();
        let relative = bodies.frame_j[joint.0].inverse() * bodies.frame_k[joint.0];
        let (_, coordinates) = content.joint_type.misfit(relative, content.pitch);
        coordinates[..content.joint_type.freedoms().len()].to_vec()
    }

    /// The largest loop-closure error at the present position, m; angles times the characteristic
    /// length.
    pub fn closure_error(&self) -> f64 {
        let assembly = &self.assembly;
        assembly.kinematics().closure_error(assembly.prescription(), self.parameters.length)
    }

    /// The forces of the last [`Self::solve`].
    pub fn forces(&self) -> &Forces {
        &self.forces
    }

    /// How much of each drive of the last [`Self::solve`] each contact's friction causes.
    pub fn shares(&mut self) -> &Shares<f64> {
        // Those of the dense system are there already.
        if let (true, Ok(balance), Some(inverse)) =
            (self.forces_by_kernel, &self.plan, &self.inverse)
        {
            let (topology, parameters) = (&self.topology, &self.parameters);
            let (prescription, motion, kinematics) = self.assembly.parts();
            let setup = Setup { topology, prescription, motion, balance };
            let sharing = self.sharing.get_or_insert_with(|| Sharing::new(&setup));
            sharing.run(&setup, parameters, &kinematics.bodies, inverse, &mut self.shares);
        }
        &self.shares
    }

    /// Rates of the actuators, rad/s or m/s, in the order of [`Mechanism::actuators`].
    pub fn drive_rates(&self) -> impl Iterator<Item = f64> {
        let (topology, bodies) = (&self.topology, self.bodies());
        let actuators = topology.actuators.iter();
        actuators.map(|a| bodies.joint_rates(topology, a.joint)[a.freedom])
    }

    /// A copy that passes the present position the other way: all rates reversed, accelerations
    /// the same, as when time runs backward. Only friction and dampers tell the difference.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut copy = self.clone();
        copy.assembly.reverse(&copy.topology, &copy.parameters);
        copy
    }

    /// Which weighting decides what is redundant; none if the position is singular.
    pub fn weighting(&self) -> Option<Weighting> {
        self.plan.as_ref().ok().map(BalancePlan::weighting)
    }

    /// The compiled kernel for use in other scalars and in control loops; none where the position
    /// is singular, or redundant in constraints and actuators at once.
    pub fn kernel(&self) -> Option<Kernel> {
        let balance = self.plan.as_ref().ok()?;
        Some(Kernel::new(&Setup {
            topology: &self.topology,
            prescription: self.assembly.prescription(),
            motion: self.assembly.program(),
            balance,
        }))
    }

    /// Moves to new targets near the present ones.
    ///
    /// # Errors
    /// See [`AssemblyError`].
    pub fn move_to(&mut self, targets: &[Target<f64>]) -> Result<(), AssemblyError> {
        self.assembly.move_to(&self.topology, &self.parameters, targets)
    }

    /// Moves along a motion in the same assembly mode; see [`Assembly::follow`].
    ///
    /// # Errors
    /// See [`AssemblyError`].
    pub fn follow(
        &mut self,
        from: f64,
        to: f64,
        motion: impl FnMut(f64, &mut [Target<f64>]),
    ) -> Result<(), AssemblyError> {
        self.assembly.follow(&self.topology, &self.parameters, from, to, motion)
    }

    /// Moves along a motion in one step of `step` seconds to `targets`, if it is smooth enough for that; see
    /// [`Assembly::leap`].
    pub fn leap(&mut self, step: f64, targets: &[Target<f64>]) -> bool {
        self.assembly.leap(&self.topology, &self.parameters, step, targets)
    }

    /// The balance of all bodies at the present position.
    pub fn balance(&self) -> NewtonEuler {
        NewtonEuler::new(&self.mechanism, &self.parameters, self.bodies())
    }

    /// The balance at the present position, decomposed.
    pub fn statics(&self) -> Statics {
        Statics::new(&self.mechanism, self.balance(), self.bodies().frame_j.clone())
    }

    /// For each contact whether its load, and with it its friction, is determined by the balance
    /// alone; `statics` is that of the present position.
    pub fn determined_loads(&self, statics: &Statics) -> Vec<bool> {
        let mut determined = vec![true; self.parameters.contacts.len()];
        for stress in statics.self_stresses() {
            for (flag, contact) in determined.iter_mut().zip(&self.parameters.contacts) {
                // The load map of the self-stress alone.
                let alone = ContactParameters { load: contact.load.seminorm(), ..contact.clone() };
                let pitch = self.parameters.pitch[contact.joint];
                let mut state = ContactState::new();
                state.press(&alone, pitch, self.bodies(), stress[contact.joint]);
                *flag &= state.load() < DETERMINED;
            }
        }
        determined
    }

    /// All forces at the present position under loads.
    ///
    /// # Errors
    /// See [`InverseError`].
    pub fn solve(&mut self, loads: &[AppliedLoad<f64>]) -> Result<&Forces, InverseError> {
        self.check_springs()?;
        self.check_overlaps()?;
        if !self.by_kernel(loads) {
            // The order of elimination suits another position, or this one is special.
            self.replan();
            if !self.by_kernel(loads) && !self.is_balanced_without_friction(loads) {
                return self.solve_carefully(loads);
            }
        }
        match self.finish(loads) {
            Ok(()) if self.forces.imbalance(self.parameters.length) <= BALANCED => Ok(&self.forces),
            Err(locked @ InverseError::Locked { .. }) => Err(locked),
            _ => self.solve_carefully(loads),
        }
    }

    /// Springs whose ends coincide have no direction to pull in.
    fn check_springs(&self) -> Result<(), InverseError> {
        let (bodies, length) = (self.bodies(), self.parameters.length);
        let is_lost = |spring| !Pull::of(spring, bodies).has_direction(spring, length);
        match self.parameters.springs.iter().position(is_lost) {
            None => Ok(()),
            Some(k) => Err(InverseError::SpringWithoutDirection {
                spring: self.mechanism.springs()[k].name.clone(),
            }),
        }
    }

    /// Whether every rod is still in its cylinder.
    fn check_overlaps(&self) -> Result<(), InverseError> {
        let bodies = self.bodies();
        for contact in &self.parameters.contacts {
            let (j, k) = (&bodies.frame_j[contact.joint], &bodies.frame_k[contact.joint]);
            let slide = (k.position - j.position).dot(j.rotation.columns[2]);
            if let Some(overlap) = contact.load.overlap(slide)
                && overlap <= 0.0
                && self.settings.friction != FrictionMode::Off
            {
                let joint = self.mechanism.joints()[contact.joint].name.clone();
                return Err(InverseError::NoOverlap { joint, beyond: -overlap });
            }
        }
        Ok(())
    }

    /// Whether it is friction that spoils the balance: it may lock the mechanism just here.
    fn is_balanced_without_friction(&mut self, loads: &[AppliedLoad<f64>]) -> bool {
        if self.settings.friction != FrictionMode::Converged {
            return false;
        }
        self.settings.friction = FrictionMode::Off;
        let balanced = self.by_kernel(loads);
        self.settings.friction = FrictionMode::Converged;
        self.by_kernel(loads);
        balanced
    }

    /// Plans the balance at the present position.
    fn replan(&mut self) {
        self.plans += 1;
        self.steady_idle_spins();
        let spins = self.spin_responses();
        let bodies = &self.assembly.kinematics().bodies;
        self.plan = BalancePlan::new(&self.topology, &self.parameters, bodies, &spins);
        self.sharing = None;
        self.inverse = match &self.plan {
            Err(_) => None,
            Ok(balance) => {
                let (topology, parameters) = (&self.topology, &self.parameters);
                let (prescription, motion, _) = self.assembly.parts();
                let setup = Setup { topology, prescription, motion, balance };
                Some(Inverse::new(&setup, parameters))
            }
        };
    }

    /// Gives bodies that spin idly, and have no inertia about the axis of that spin, some. By
    /// convention nothing turns about it, so no result changes; but without it the acceleration
    /// would be anything, or, with friction at the body, infinite: this is the limit of little
    /// inertia.
    fn steady_idle_spins(&mut self) {
        let length = self.parameters.length;
        for spin in self.assembly.prescription().spins() {
            let body = spin.body.0;
            let inertia = &mut self.parameters.inertia[body];
            let size = inertia.trace() + self.parameters.mass[body] * length * length;
            if spin.axis.dot(*inertia * spin.axis) <= 1e-12 * size {
                let fictitious = if size > 0.0 { size } else { length * length };
                let [x, y, z] = (spin.axis * fictitious).to_array();
                let about_axis = Mat3::from_columns(spin.axis * x, spin.axis * y, spin.axis * z);
                *inertia = *inertia + about_axis;
            }
        }
    }

    fn spin_responses(&mut self) -> Vec<Vec<f64>> {
        let freedoms = self.topology.freedoms();
        let (prescription, motion, kinematics) = self.assembly.parts();
        (0..prescription.spins().len())
            .map(|spin| {
                let mut response = vec![0.0; freedoms];
                kinematics.response_to_spin(prescription, motion, spin, &mut response);
                response
            })
            .collect()
    }

    /// Solves by the kernel; false where there is no plan or its numbers cannot be trusted.
    fn by_kernel(&mut self, loads: &[AppliedLoad<f64>]) -> bool {
        let (Ok(balance), Some(inverse)) = (&self.plan, &mut self.inverse) else { return false };
        let topology = &self.topology;
        self.assembly.forget_spins(topology);
        let (prescription, motion, kinematics) = self.assembly.parts();
        let setup = Setup { topology, prescription, motion, balance };
        inverse.solve(&setup, &self.parameters, kinematics, loads, &self.settings);
        inverse.is_balanced(&setup, &self.parameters)
    }

    /// Takes over what the kernel found, after the checks of friction.
    fn finish(&mut self, loads: &[AppliedLoad<f64>]) -> Result<(), InverseError> {
        let (Ok(balance), Some(inverse)) = (&self.plan, &mut self.inverse) else {
            return Err(InverseError::Unsettled);
        };
        let (topology, parameters) = (&self.topology, &self.parameters);
        let settings = &self.settings;
        let (prescription, motion, kinematics) = self.assembly.parts();
        let setup = Setup { topology, prescription, motion, balance };
        let is_coupled = settings.friction == FrictionMode::Converged
            && inverse.contacts().iter().any(|contact| contact.sliding > 0.0);
        let strength = match is_coupled {
            true => self.room.strength(inverse, &setup, parameters, &kinematics.bodies),
            false => 0.0,
        };
        self.strength = strength;
        let is_unique = strength < 1.0;
        let settled =
            inverse.friction_settled(settings) || (is_unique && inverse.friction_stagnated());
        if !settled || !is_unique || !inverse.is_balanced(&setup, parameters) {
            // There may be other solutions, or none: follow the one that is connected with no friction.
            // It is found, or lost where friction locks.
            let followed = wedge::follow_friction(
                inverse, &setup, parameters, kinematics, loads, settings, 1.0,
            );
            if let Err(lock) = followed {
                // Where there certainly is one, what was lost is digits. (A thread's load contains its
                // own friction, and has no limit where that locks it.)
                let is_thread =
                    |contact: &ContactParameters<f64>| contact.shape == ContactShape::Thread;
                let exists = is_unique && !parameters.contacts.iter().any(is_thread);
                return Err(match exists {
                    true => InverseError::Unsettled,
                    false => locked(&self.mechanism, parameters, lock),
                });
            }
        }
        self.forces_by_kernel = true;
        let forces = &mut self.forces;
        forces.read(&kinematics.bodies, inverse);
        let position = bounds::Position { setup, parameters, kinematics, loads, settings };
        bounds::bound_drives(forces, inverse, position);
        let dissipated = forces.contacts.iter().map(|c| c.power);
        let bodies = &kinematics.bodies;
        forces.power = Power::new(topology, parameters, bodies, &forces.drives, dissipated, loads);
        Ok(())
    }

    /// The same by dense decompositions, friction by a plain fixed point: slow, for special
    /// positions, and as an oracle. It leaves the intervals of contacts at rest at zero width, and
    /// says so in [`Forces::bounded`].
    ///
    /// # Errors
    /// See [`InverseError`].
    pub fn solve_carefully(&mut self, loads: &[AppliedLoad<f64>]) -> Result<&Forces, InverseError> {
        self.check_springs()?;
        self.check_overlaps()?;
        let statics = self.statics();
        let spins = self.spin_responses();
        let bodies = &self.assembly.kinematics().bodies;
        let accelerations = &self.assembly.state().accelerations;
        let solution = careful::solve(
            &careful::Position {
                mechanism: &self.mechanism,
                topology: &self.topology,
                parameters: &self.parameters,
                statics: &statics,
                bodies,
            },
            accelerations,
            &spins,
            loads,
            &self.settings,
        )
        .map_err(|uncarried| self.in_words(&uncarried))?;
        if !solution.settled {
            return Err(InverseError::Unsettled);
        }
        if let Some(lock) = solution.lock {
            return Err(locked(&self.mechanism, &self.parameters, lock));
        }
        let has_friction = self.settings.friction != FrictionMode::Off;
        self.forces.take(bodies, &solution, has_friction);
        self.forces_by_kernel = false;
        self.shares.clone_from(&solution.shares);
        self.forces.power = Power::new(
            &self.topology,
            &self.parameters,
            &solution.bodies,
            &self.forces.drives,
            self.forces.contacts.iter().map(|c| c.power),
            loads,
        );
        let residual = self.forces.imbalance(self.parameters.length);
        if residual <= BALANCED {
            Ok(&self.forces)
        } else {
            Err(InverseError::Inaccurate { residual })
        }
    }

    /// Stops the mechanism where it is, all rates and accelerations zero, and looks at what static
    /// friction does there. [`Self::forces`] are then those at rest.
    ///
    /// # Errors
    /// See [`InverseError`]; [`InverseError::Unsettled`] where the position is singular, or
    /// constraints and actuators are both redundant.
    pub fn rest(&mut self, loads: &[AppliedLoad<f64>]) -> Result<Rest, InverseError> {
        self.assembly.stop(&self.topology, &self.parameters);
        self.solve(loads)?;
        if !self.forces.bounded {
            return Err(InverseError::Unsettled);
        }
        let (Ok(balance), Some(inverse)) = (&self.plan, &mut self.inverse) else {
            return Err(InverseError::Unsettled);
        };
        let (topology, parameters, settings) = (&self.topology, &self.parameters, &self.settings);
        let (prescription, motion, kinematics) = self.assembly.parts();
        let setup = Setup { topology, prescription, motion, balance };
        let position = bounds::Position { setup, parameters, kinematics, loads, settings };
        let mut rest = rest::examine(inverse, position);
        rest.take_intervals(&self.forces);
        Ok(rest)
    }

    /// An uncarried load with names and places.
    fn in_words(&self, uncarried: &Uncarried) -> InverseError {
        let (body, motion) = uncarried.motion.in_words(&self.mechanism, self.parameters.origin);
        let unit = if uncarried.motion.turns { "N m" } else { "N" };
        InverseError::CannotCarry { body, motion, missing: uncarried.missing.abs(), unit }
    }
}

/// The sign of the permutation by which `coordinates` are the actuators; none if they are not.
fn order_of_actuators(topology: &Topology, coordinates: &[Coordinate]) -> Option<f64> {
    let place = |coordinate: &Coordinate| {
        let &Coordinate::Joint { joint: JointId(joint), freedom } = coordinate else { return None };
        let actuators = &topology.actuators;
        actuators.binary_search_by_key(&(joint, freedom), |a| (a.joint, a.freedom)).ok()
    };
    let mut places = coordinates.iter().map(place).collect::<Option<Vec<usize>>>()?;
    // Each exchange puts one where it belongs, so there are fewer than coordinates; a coordinate that is
    // prescribed twice never gets there.
    let mut sign = 1.0;
    for here in 0..places.len() {
        while places[here] != here {
            let there = places[here];
            if *places.get(there)? == there {
                return None;
            }
            places.swap(here, there);
            sign = -sign;
        }
    }
    Some(sign)
}

/// Where the solution is lost, with the joint's name.
fn locked(mechanism: &Mechanism, parameters: &Parameters<f64>, lock: Lock) -> InverseError {
    let joint = parameters.contacts[lock.contact].joint;
    InverseError::Locked {
        joint: mechanism.joints()[joint].name.clone(),
        percent: 100.0 * lock.part,
    }
}
