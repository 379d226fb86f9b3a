//! Inverse dynamics along a motion in `f64`, with checks of all results.
//!
//! Equation (F9) of the book's theory.

mod checkpoint;
mod planning;
mod program;
mod solve;

use super::contributions::Contributions;
use super::coupling::FrictionCoupling;
use super::error::InverseError;
use super::forces::Forces;
use super::inverse::Inverse;
use super::model::Model;
use super::settings::{FrictionMode, Settings};
use super::structure::Weighting;
use crate::friction_problem::normal_load::Configuration;
use crate::kinematics::{
    Assembly, AssemblyError, AssemblyReport, Bodies, Coordinate, Kinematics, MotionConstraints,
    State, Target, actuator_rate, body_twists, closure_error,
};
use crate::linalg::StaticLu;
use crate::mechanism::{BodyId, JointId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::statics::newton_euler::NewtonEuler;
use crate::statics::{DETERMINED, IdleAxis, Statics};
use crate::topology::{Topology, TreeRule};
use nalgebra::DMatrix;
use program::ProgramOfSolver;
use std::sync::Arc;

/// Solver that moves a mechanism along prescribed coordinates: it closes the loops, follows
/// motions, and computes and checks all forces.
///
/// ```
/// use stiction_core::dynamics::{InverseDynamics, Settings};
/// use stiction_core::joint::JointType;
/// use stiction_core::kinematics::{Coordinate, Target};
/// use stiction_core::mechanism::{BodySpec, JointId, JointSpec, MechanismBuilder};
/// use stiction_core::spatial::Vec3;
///
/// let pendulum = MechanismBuilder::new("pendulum")
///     .gravity(Vec3::new(0.0, -9.81, 0.0))
///     .body(BodySpec::new("bob").mass(2.0).com(Vec3::new(0.5, 0.0, 0.0)))
///     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
///     .build()?;
/// let angle = Coordinate::Joint { joint: JointId(0), dof: 0 };
/// let level = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
/// let mut solver =
///     InverseDynamics::new(pendulum, &[], &[angle], &[level], Settings::default())?;
/// // Held level: 2 kg * 9.81 m/s^2 at half a metre.
/// assert!((solver.solve(&[])?.efforts[0] - 9.81).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct InverseDynamics {
    mechanism: Arc<Mechanism>,
    topology: Arc<Topology>,
    parameters: Arc<Parameters<f64>>,
    assembly: Assembly,
    settings: Settings,
    /// Model compiled near the present configuration, with the results of its last computation, or
    /// the reason why the model cannot be compiled.
    compiled: Result<Compiled, InverseError>,
    /// First static LU factorisation of the rate equations. It makes the signs of determinants
    /// comparable along a motion, even if the equations are compiled again.
    first_rates: Arc<StaticLu>,
    forces: Forces,
    /// Coupling bound of the last solution by the compiled model; see
    /// [`InverseDynamics::coupling`].
    strength: f64,
    /// Responses to unit friction forces at the configuration of the last solution by the compiled
    /// model.
    friction_coupling: FrictionCoupling,
    /// True if the compiled model computed the last forces, false if the dense fallback did.
    forces_by_kernel: bool,
    shares: Contributions<f64>,
    /// Recorded program that replaces the kernels along a motion.
    program: Option<ProgramOfSolver>,
    /// Number of times that the balance has been compiled.
    plans: u64,
    /// Coordinates of the spanning tree at which the balance was compiled.
    compiled_at: Vec<f64>,
}

/// Copy of a solver in reversed motion that is updated at successive configurations; see
/// [`InverseDynamics::reversed`]. Buffers and the compiled model are copied only once along a
/// motion.
#[derive(Clone, Debug, Default)]
pub struct Mirror {
    copy: Option<InverseDynamics>,
    /// Numbers of compilations of the original and of the copy at the last update of the copy.
    plans: [(u64, u64); 2],
}

impl Mirror {
    /// Returns the copy of `solver` in reversed motion. The copy equals
    /// [`InverseDynamics::reversed`], except for the forces of the last solution. Every call
    /// requires the same `solver`.
    pub fn of(&mut self, solver: &InverseDynamics) -> &mut InverseDynamics {
        let plans = |solver: &InverseDynamics| (solver.plans, solver.assembly.plans());
        let kept = self.copy.take().filter(|copy| self.plans == [plans(solver), plans(copy)]);
        let mut copy = kept.unwrap_or_else(|| solver.clone());
        self.plans = [plans(solver), plans(&copy)];
        copy.settings = solver.settings;
        copy.assembly.go_to(&solver.assembly);
        copy.assembly.reverse(&copy.parameters);
        self.copy.insert(copy)
    }
}

/// Compiled model and the results of its last computation.
#[derive(Clone, Debug)]
struct Compiled {
    model: Model,
    inverse: Inverse<f64>,
}

/// Inputs and results of the compiled model at the present configuration.
pub(super) struct Parts<'a> {
    pub(super) model: &'a Model,
    pub(super) inverse: &'a Inverse<f64>,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) kinematics: &'a mut Kinematics<f64>,
    pub(super) settings: &'a Settings,
}

impl InverseDynamics {
    /// Creates a solver and assembles the mechanism such that each coordinate in `coordinates` has
    /// the value of the corresponding target in `targets`. The assembly mode is selected by
    /// [`JointSpec::start`](crate::mechanism::JointSpec::start) and by `initial_poses`, initial
    /// guesses of body poses in the ground frame.
    ///
    /// # Errors
    /// See [`AssemblyError`].
    ///
    /// # Panics
    /// If the numbers of targets and coordinates differ, or if a given body, joint or DOF does not
    /// exist.
    pub fn new(
        mechanism: Mechanism,
        initial_poses: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
        settings: Settings,
    ) -> Result<Self, AssemblyError> {
        let rule = TreeRule::Structure;
        Self::with_tree(mechanism, rule, initial_poses, coordinates, targets, settings)
    }

    /// Creates a solver and assembles the mechanism like [`Self::new`], with a spanning tree
    /// selected by `rule`.
    ///
    /// # Errors
    /// See [`AssemblyError`].
    ///
    /// # Panics
    /// See [`Self::new`].
    pub fn with_tree(
        mechanism: Mechanism,
        rule: TreeRule,
        initial_poses: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
        settings: Settings,
    ) -> Result<Self, AssemblyError> {
        let topology = Arc::new(Topology::with_tree(&mechanism, rule));
        let parameters = Arc::new(Parameters::new(&mechanism));
        let assembly =
            Assembly::new(&mechanism, &topology, &parameters, initial_poses, coordinates, targets)?;
        let forces = Forces::new(
            [topology.actuators.len(), mechanism.joints().len(), mechanism.gearings().len()],
            parameters.interfaces.len(),
        );
        let first_rates = Arc::clone(&assembly.model().rates);
        let shares = Contributions::new(topology.actuators.len(), parameters.interfaces.len());
        let mut solver = Self {
            mechanism: Arc::new(mechanism),
            topology,
            parameters,
            assembly,
            settings,
            compiled: Err(InverseError::Singular),
            first_rates,
            forces,
            strength: 0.0,
            friction_coupling: FrictionCoupling::default(),
            forces_by_kernel: true,
            shares,
            program: None,
            plans: 0,
            compiled_at: Vec::new(),
        };
        solver.replan();
        Ok(solver)
    }

    /// Returns the mechanism that the solver moves.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Returns the topology: spanning tree and cut joints.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Returns the parameters of the mechanism.
    pub fn parameters(&self) -> &Parameters<f64> {
        &self.parameters
    }

    /// Returns the settings: friction mode, tolerances and iteration limits.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the settings for modification; changes apply from the next [`Self::solve`].
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// Returns coordinates, rates and accelerations of the spanning tree at the present instant.
    pub fn state(&self) -> &State<f64> {
        self.assembly.state()
    }

    /// Returns the targets of the prescribed coordinates at the present instant.
    pub fn targets(&self) -> &[Target<f64>] {
        self.assembly.targets()
    }

    /// Returns the motion constraints: loop closures, prescribed coordinates and local degrees of
    /// freedom.
    pub fn constraints(&self) -> &MotionConstraints {
        self.assembly.motion_constraints()
    }

    /// Returns the comparison of the first assembled configuration with the requested `home` and
    /// `start` values and the prescribed coordinates.
    pub fn assembly_report(&self) -> &AssemblyReport {
        self.assembly.report()
    }

    /// Returns the motion of all bodies. The accelerations of local degrees of freedom are those of
    /// the last [`Self::solve`].
    pub fn bodies(&self) -> &Bodies<f64> {
        &self.assembly.kinematics().bodies
    }

    /// Returns the bound on the coupling of friction and reactions in the last [`Self::solve`]. If
    /// the bound is below one, the solution is unique. Otherwise other solutions may exist, and the
    /// computed solution is the one connected to the frictionless solution. The bound is zero
    /// without friction or without coupling. `None` if the configuration is singular, or if
    /// constraints and actuators are both redundant.
    pub fn coupling(&self) -> Option<f64> {
        if self.settings.friction != FrictionMode::Converged
            || self.parameters.interfaces.is_empty()
        {
            return Some(0.0);
        }
        // Only the compiled model computes the bound, not the dense fallback.
        let strength = if self.forces_by_kernel { self.strength } else { f64::INFINITY };
        strength.is_finite().then_some(strength)
    }

    /// Makes [`Self::coupling`] accept bounds up to `bound` without refinement to the smallest
    /// bound, which saves time. Bounds of one or more are always refined.
    #[doc(hidden)]
    pub fn accept_coupling_up_to(&mut self, bound: f64) {
        self.friction_coupling.accept_up_to(bound.min(1.0 - f64::EPSILON));
    }

    /// Returns inputs and results of the compiled model at the present configuration. `None` if the
    /// configuration is singular, or if constraints and actuators are both redundant.
    pub(super) fn parts(&mut self) -> Option<Parts<'_>> {
        self.share_kinematics();
        let Compiled { model, inverse } = self.compiled.as_ref().ok()?;
        let (parameters, settings) = (&*self.parameters, &self.settings);
        let (_, kinematics) = self.assembly.parts();
        Some(Parts { model, inverse, parameters, kinematics, settings })
    }

    /// Returns the sign of the determinant of loop closures and actuators with respect to the DOFs
    /// of the spanning tree, up to a sign that is constant along a motion. The result distinguishes
    /// the two sides of an actuation (type 2) singularity, at which the determinant vanishes and
    /// the mechanism has instantaneous mobility with all actuators locked. `None` if the number of
    /// actuators differs from the number of prescribed coordinates, or is zero.
    pub fn side(&mut self) -> Option<f64> {
        if let Some(side) = self.side_by_program() {
            return side;
        }
        let topology = &self.topology;
        let (model, kinematics) = self.assembly.parts();
        let coordinates = model.constraints().coordinates();
        let count = coordinates.len();
        if count == 0 || count != topology.actuators.len() {
            return None;
        }
        kinematics.factor_here(model, &self.parameters);
        // Equations that were compiled again at another configuration have a different constant
        // factor.
        let own = match Arc::ptr_eq(&model.rates, &self.first_rates) {
            true => kinematics.sign(),
            false => kinematics.sign_by(&self.first_rates)?,
        };
        // If exactly the actuators are prescribed, the matrix is a permutation.
        if let Some(sign) = order_of_actuators(topology, coordinates) {
            return Some(sign * own.signum());
        }
        let mut matrix = DMatrix::zeros(count, count);
        kinematics.responses_to_coordinates(model, |column, rates| {
            for (tree_dof, content) in topology.tree_dofs.iter().enumerate() {
                if let Some(actuator) = content.actuator {
                    matrix[(actuator, column)] = rates[tree_dof];
                }
            }
            if !topology.cut_actuators.is_empty() {
                let bodies = &kinematics.bodies;
                let twists = body_twists(topology, bodies, rates);
                for &row in &topology.cut_actuators {
                    let actuator = &topology.actuators[row];
                    matrix[(row, column)] = actuator_rate(topology, bodies, actuator, &twists);
                }
            }
        });
        // The determinant of closures and actuators equals the determinant of this matrix times the
        // determinant of closures and coordinates.
        let determinant = matrix.determinant() * own;
        determinant.is_finite().then(|| determinant.signum())
    }

    /// Returns the local degrees of freedom: for each, the index of the body and the axis of the
    /// spin in world axes.
    pub fn idle_axes(&self) -> Vec<IdleAxis> {
        let spins = self.assembly.motion_constraints().spins().iter();
        let pose = &self.bodies().pose;
        spins.map(|spin| (spin.body.0, pose[spin.body.0].rotation * spin.axis)).collect()
    }

    /// Returns the scalar coordinates of a joint, m and rad; empty for joints that rotate in all
    /// directions. Angles are between -pi and pi, except for helical joints.
    pub fn joint_coordinates(&self, joint: JointId) -> Vec<f64> {
        let content = &self.mechanism.joints()[joint.0];
        match content.joint_type.has_scalar_coordinates() {
            true => (0..content.joint_type.dofs().len())
                .map(|dof| self.joint_coordinate(joint, dof))
                .collect(),
            false => Vec::new(),
        }
    }

    /// Returns the coordinate of one DOF of a joint, m or rad; zero for joints without scalar
    /// coordinates.
    fn joint_coordinate(&self, joint: JointId, dof: usize) -> f64 {
        let content = &self.mechanism.joints()[joint.0];
        if !content.joint_type.has_scalar_coordinates() {
            return 0.0;
        }
        let bodies = self.bodies();
        let relative = bodies.frame_j[joint.0].inverse() * bodies.frame_k[joint.0];
        let (_, coordinates) = content.joint_type.nearest(relative, content.pitch);
        coordinates.get(dof).copied().unwrap_or(0.0)
    }

    /// Returns coordinate (m or rad, see [`Self::joint_coordinates`]), rate and acceleration of a
    /// degree of freedom of a joint. The coordinate is zero for joints without scalar coordinates.
    pub fn joint_motion(&self, joint: JointId, dof: usize) -> Target<f64> {
        let value = self.joint_coordinate(joint, dof);
        self.bodies().joint_motion(&self.topology, &self.parameters, (joint.0, dof), value)
    }

    /// Returns the largest loop-closure error at the present configuration, m. Angular errors are
    /// multiplied by the characteristic length.
    pub fn closure_error(&self) -> f64 {
        let assembly = &self.assembly;
        let kinematics = assembly.kinematics();
        if kinematics.has_errors() {
            return kinematics.closure_error(assembly.motion_constraints(), self.parameters.length);
        }
        let at = (&kinematics.bodies, &*assembly.state().coordinates);
        closure_error(&self.topology, &self.parameters, at)
    }

    /// Returns the forces of the last successful [`Self::solve`], even if the mechanism has moved
    /// since then. All forces are zero before the first solution. Prefer the return value of
    /// [`Self::solve`].
    pub fn forces(&self) -> &Forces {
        &self.forces
    }

    /// Computes the friction contributions to each effort for the last [`Self::solve`]. The result
    /// is valid until the mechanism moves.
    pub fn shares(&mut self) -> &Contributions<f64> {
        // The dense fallback computes the contributions itself.
        self.share_kinematics();
        if let (true, Ok(Compiled { model, inverse })) = (self.forces_by_kernel, &self.compiled) {
            self.shares.clear();
            if inverse.has_friction() {
                let bodies = &self.assembly.kinematics().bodies;
                let coupling = &mut self.friction_coupling;
                let responses = coupling.responses(inverse, model, &self.parameters, bodies, false);
                for (interface, state) in inverse.interfaces().iter().enumerate() {
                    // Interfaces at rest have no friction.
                    if state.sliding > 0.0 {
                        let component = responses.components(interface).start;
                        let friction = state.friction();
                        for (actuator, share) in self.shares.row(interface).iter_mut().enumerate() {
                            *share = responses.effort(component, actuator) * friction;
                        }
                    }
                }
            }
        }
        &self.shares
    }

    /// Computes the efforts for the opposite motion at the present configuration, with the same
    /// accelerations and loads as in the last [`Self::solve`]. `None` if the solution may not be
    /// unique, if the mechanism has dampers, or if the last solution did not store the responses to
    /// unit friction forces; use [`Self::reversed`] in these cases.
    #[doc(hidden)]
    pub fn reversed_efforts(&mut self) -> Option<Vec<f64>> {
        let is_unique = self.forces_by_kernel && self.strength < 1.0;
        // Damper forces change their sign in the opposite motion.
        let has_dampers = self.parameters.has_dampers();
        if !is_unique || has_dampers || self.settings.friction != FrictionMode::Converged {
            return None;
        }
        let Ok(Compiled { inverse, .. }) = &self.compiled else { return None };
        let (parameters, bodies) = (&*self.parameters, &self.assembly.kinematics().bodies);
        let at = Configuration { parameters, bodies };
        self.friction_coupling.reversed_efforts(inverse.interfaces(), at)
    }

    /// Returns the rates of the actuators, rad/s or m/s, in the order of [`Mechanism::actuators`].
    pub fn actuator_rates(&self) -> impl Iterator<Item = f64> {
        let (topology, bodies) = (&self.topology, self.bodies());
        let actuators = topology.actuators.iter();
        actuators.map(|actuator| bodies.actuator_rate(topology, *actuator))
    }

    /// Returns a copy with reversed motion at the present configuration: all rates change their
    /// sign, and the accelerations stay the same. Only friction and damper forces differ.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut copy = self.clone();
        copy.assembly.reverse(&copy.parameters);
        copy
    }

    /// Returns the weighting that selects redundant forces. `None` if the configuration is
    /// singular, or if constraints and actuators are both redundant.
    pub fn weighting(&self) -> Option<Weighting> {
        self.compiled.as_ref().ok().map(|compiled| compiled.model.balance.weighting())
    }

    /// Returns the compiled model, for other scalar types and for control loops.
    ///
    /// # Errors
    /// [`InverseError::Singular`] or [`InverseError::TwoWeightings`].
    pub fn model(&self) -> Result<Model, InverseError> {
        let Compiled { model, .. } = self.compiled.as_ref().map_err(Clone::clone)?;
        Ok(Model { kinematic: self.assembly.model().clone(), ..model.clone() })
    }

    /// Moves to new targets, one for each coordinate, by Newton's method from the present
    /// configuration. This method does not check the assembly mode; use [`Self::follow`] for that
    /// purpose. Forces remain those of the last [`Self::solve`].
    ///
    /// # Errors
    /// See [`AssemblyError`]. After an error the solver keeps its configuration.
    ///
    /// # Panics
    /// If the numbers of targets and prescribed coordinates differ.
    pub fn move_to(&mut self, targets: &[Target<f64>]) -> Result<(), AssemblyError> {
        self.move_ahead(0.0, targets)
    }

    /// Moves to new targets as [`Self::move_to`], where `ahead` seconds have passed since the
    /// present configuration. Newton's method starts from this configuration extrapolated with its
    /// rates, which saves steps if the targets move smoothly.
    ///
    /// # Errors
    /// See [`Self::move_to`].
    ///
    /// # Panics
    /// If the numbers of targets and prescribed coordinates differ.
    pub fn move_ahead(&mut self, ahead: f64, targets: &[Target<f64>]) -> Result<(), AssemblyError> {
        self.assembly.move_to(&self.parameters, ahead, targets)
    }

    /// Follows a motion in the same assembly mode from the time `from` of the present configuration
    /// to the time `to`, s. `motion` writes the targets at a given time. Steps are halved if the
    /// motion of the bodies is not smooth. Forces remain those of the last [`Self::solve`].
    ///
    /// # Errors
    /// See [`AssemblyError`]; this includes jumps that remain after the step has been halved. Loops
    /// may be open after an error: move to a reachable configuration before solving again.
    pub fn follow(
        &mut self,
        from: f64,
        to: f64,
        motion: impl FnMut(f64, &mut [Target<f64>]),
    ) -> Result<(), AssemblyError> {
        self.assembly.follow(&self.parameters, from, to, motion)
    }

    /// Follows a motion to `targets` in a single step of `step` seconds, which may span many
    /// samples. Returns false, and keeps the present configuration, if the motion is not smooth
    /// enough.
    ///
    /// # Panics
    /// If the numbers of targets and prescribed coordinates differ.
    #[must_use = "`false` means that the configuration has not changed"]
    pub fn follow_in_one_step(&mut self, step: f64, targets: &[Target<f64>]) -> bool {
        self.assembly.follow_in_one_step(&self.parameters, step, targets)
    }

    /// Returns to a configuration that the solver has visited before. `known` contains the
    /// coordinates, rates and accelerations that [`Self::state`] had there, and `targets` the
    /// prescribed targets there. Returns false, and keeps the present configuration, if state and
    /// targets are inconsistent.
    #[doc(hidden)]
    #[must_use = "`false` means that the configuration has not changed"]
    pub fn return_to(&mut self, known: [&[f64]; 3], targets: &[Target<f64>]) -> bool {
        self.assembly.return_to(&self.parameters, known, targets)
    }

    /// Enables extrapolation from the last configurations while following a motion, which saves
    /// Newton steps. Results then depend on the previous configurations, within round-off.
    #[doc(hidden)]
    pub fn extrapolate(&mut self) {
        self.assembly.extrapolate();
        self.friction_coupling.keep_history();
    }

    /// Returns the Newton-Euler equations of all bodies at the present configuration.
    pub fn balance(&self) -> NewtonEuler {
        NewtonEuler::new(&self.mechanism, &self.parameters, self.bodies())
    }

    /// Returns the decomposition of the Newton-Euler equations at the present configuration.
    pub fn statics(&self) -> Statics {
        Statics::new(&self.mechanism, self.balance(), self.bodies().frame_j.clone())
    }

    /// Returns, for each friction interface, true if equilibrium alone determines its normal force
    /// and therefore its friction. `statics` must belong to the present configuration.
    pub fn determined_loads(&self, statics: &Statics) -> Vec<bool> {
        let mut determined = vec![true; self.parameters.interfaces.len()];
        let at = Configuration { parameters: &self.parameters, bodies: self.bodies() };
        let mut own = vec![Vec::new(); self.mechanism.joints().len()];
        (0..determined.len()).for_each(|interface| own[at.joint(interface)].push(interface));
        for (joint, wrench) in statics.self_stresses().flatten() {
            for &interface in &own[joint] {
                // Normal load under the self-stress alone.
                let change = at.largest_load_change(interface, wrench, 0.0);
                determined[interface] &= change < DETERMINED;
            }
        }
        determined
    }
}

/// Returns the sign of the permutation that maps `coordinates` to the actuators; `None` if the
/// coordinates are not exactly the actuated DOFs.
fn order_of_actuators(topology: &Topology, coordinates: &[Coordinate]) -> Option<f64> {
    let place = |coordinate: &Coordinate| {
        let &Coordinate::Joint { joint: JointId(joint), dof } = coordinate else { return None };
        let actuators = &topology.actuators;
        actuators.binary_search_by_key(&(joint, dof), |a| (a.joint, a.dof)).ok()
    };
    let mut places = coordinates.iter().map(place).collect::<Option<Vec<usize>>>()?;
    // Each exchange moves one coordinate to its final place, so there are fewer exchanges than
    // coordinates. A coordinate that is prescribed twice has no place.
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
