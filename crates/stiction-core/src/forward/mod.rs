//! Forward dynamics: motion of a mechanism under given forces, with joints that stick and slip.
//!
//! One linear system yields the accelerations and all reactions; the constraints are differentiated
//! twice (index 1). The friction of a joint depends on the reaction of the same joint, so the
//! solver computes frictions and reactions together. The accelerations decide whether an interface
//! at rest sticks; a sticking interface does not creep. See [`Forward`] and [`Simulation`].
//!
//! [`Forward`] is the model. `Data` contains the quantities at one instant that do not depend on
//! the stick-slip modes of the interfaces. A [`Simulation`] advances the state and stores the
//! results as an [`Instant`].

mod affine_friction;
mod balance;
mod cash_karp;
mod classical;
mod complementarity;
mod constraint_jacobian;
mod constraint_rank;
mod coupling;
mod data;
mod dop853;
mod error;
mod initial;
mod inputs;
mod instant;
mod integrator;
mod joints;
mod mass_matrix;
mod motor_shafts;
mod project;
mod recorded;
mod rotors;
mod simulation;
mod solve;
mod sparse;
mod stick;
mod surface;
mod time_stepping;
mod transmitted;
mod verified;

pub use affine_friction::InterfaceMode;
pub use error::ForwardError;
pub use initial::Known;
pub use inputs::{ConstantEfforts, Inputs, View};
pub use instant::Instant;
pub use simulation::{
    Checkpoint, Event, EventKind, Linearisation, LinearisationError, Method, PayloadChange,
    Settings, Simulation,
};

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use error::Competitor;
#[doc(hidden)]
pub use instant::{Account, InterfaceSample};
#[doc(hidden)]
pub use recorded::{AccelerationProgram, ProgramInputs, moving_results};
#[doc(hidden)]
pub use simulation::Energies;
#[doc(hidden)]
pub use simulation::RateJump;

use crate::kinematics::{Assembly, AssemblyReport, Coordinate, State, Target, column_scales};
use crate::mechanism::{BodyId, Mechanism, MotorShaft};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::{Topology, TreeRule};
use recorded::Recorded;
use rotors::{Rotor, shaft_friction};
use sparse::closures::{Closures, Reach};
use std::sync::Arc;

/// Number of DOFs of the spanning tree from which the sparse solver is faster than the dense one.
const SPARSE: usize = 25;

/// Model of a mechanism for forward dynamics. Immutable.
///
/// ```
/// use stiction_core::forward::{ConstantEfforts, EventKind, Forward, Settings};
/// use stiction_core::friction::{JointFriction, Law};
/// use stiction_core::joint::JointType;
/// use stiction_core::kinematics::{Coordinate, Target};
/// use stiction_core::mechanism::{BodySpec, JointId, JointSpec, MechanismBuilder};
/// use stiction_core::spatial::{Mat3, Pose, Vec3};
///
/// // A block of 2 kg that is pushed along x: the rail's z axis is its direction of sliding.
/// let rail = Pose { rotation: Mat3::between(Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 0.0)), ..Pose::identity() };
/// let dry = JointFriction::guide(Law::coulomb_viscous(0.25, 0.0));
/// let mechanism = MechanismBuilder::new("block")
///     .gravity(Vec3::new(0.0, -10.0, 0.0))
///     .body(BodySpec::new("block").mass(2.0))
///     .joint(
///         JointSpec::new("rail", JointType::Prismatic, "ground", "block")
///             .frames(rail, rail)
///             .actuated()
///             .friction(dry),
///     )
///     .build()?;
/// let forward = Forward::new(mechanism, &[]);
/// let slide = Coordinate::Joint { joint: JointId(0), dof: 0 };
/// let start = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
/// let state = forward.assemble(&[], &[slide], &[start])?;
///
/// // A push of 4 N is below the friction limit 0.25 * 20 N; a push of 9 N leaves 4 N for 2 kg.
/// let mut weak = ConstantEfforts(vec![4.0]);
/// let mut simulation = forward.start(0.0, state.clone(), Settings::default(), &mut weak)?;
/// simulation.advance(1.0, &mut weak)?;
/// assert_eq!(simulation.joint_motion(JointId(0), 0).value, 0.0);
///
/// let mut strong = ConstantEfforts(vec![9.0]);
/// let mut simulation = forward.start(0.0, state, Settings::default(), &mut strong)?;
/// simulation.advance(1.0, &mut strong)?;
/// let motion = simulation.joint_motion(JointId(0), 0);
/// assert!((motion.acceleration - 2.0).abs() < 1e-12 && (motion.value - 1.0).abs() < 1e-9);
/// // Normal force on the block, and the push less friction.
/// let (force, _) = simulation.instant().reactions()[0];
/// assert!((force.y - 20.0).abs() < 1e-12 && (force.x - 4.0).abs() < 1e-12);
/// assert!(!simulation.events().iter().any(|event| matches!(event.kind, EventKind::Sticks { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Forward {
    mechanism: Mechanism,
    /// Copy of the mechanism with additional shafts for motors, and these shafts, see
    /// [`Mechanism::trains_on_shafts`]. `None` if no motor needs an additional shaft.
    with_shafts: Option<(Mechanism, Vec<MotorShaft>)>,
    topology: Arc<Topology>,
    parameters: Parameters<f64>,
    /// Indices of the actuators with prescribed motion.
    prescribed: Vec<usize>,
    /// Rotors of drive trains.
    rotors: Vec<Rotor>,
    /// Scale of each DOF of the spanning tree: the characteristic length for a translation, one for
    /// a rotation.
    columns: Vec<f64>,
    /// Sparse system of the loop closures for computing accelerations; `None` if accelerations are
    /// computed by dense linear algebra.
    closures: Option<Arc<Closures>>,
    /// Sparse system of the loop closures for projecting coordinates and rates onto the
    /// constraints; `None` if the projection uses dense linear algebra.
    projections: Option<Arc<Closures>>,
    /// Recorded program, if one is used.
    recorded: Option<Recorded>,
}

impl Forward {
    /// Creates the model. `prescribed` contains the indices, in the order of
    /// [`Mechanism::actuators`], of actuators whose coordinate is a given function of time; all
    /// other actuators exert efforts. Indices without an actuator are ignored.
    pub fn new(mechanism: Mechanism, prescribed: &[usize]) -> Self {
        Self::with_tree(mechanism, TreeRule::Structure, prescribed)
    }

    /// Creates the model like [`Self::new`], with a spanning tree selected by `rule`. With the rule
    /// [`TreeRule::Held`], the solver is sparse for any number of DOFs.
    pub fn with_tree(mechanism: Mechanism, rule: TreeRule, prescribed: &[usize]) -> Self {
        let with_shafts = mechanism.with_shafts();
        let simulated = with_shafts.as_ref().map_or(&mechanism, |(simulated, _)| simulated);
        let rotors = Rotor::all(simulated);
        let topology = Arc::new(Topology::with_tree(simulated, rule));
        let is_large = topology.is_held() || topology.dofs() >= SPARSE;
        let mut parameters = Parameters::new(simulated);
        parameters.interfaces.extend(shaft_friction(simulated));
        let columns = column_scales(&topology, parameters.length);
        let known = 0..topology.actuators.len();
        let prescribed = prescribed.iter().copied().filter(|a| known.contains(a)).collect();
        let mut model = Self {
            mechanism,
            with_shafts,
            topology,
            parameters,
            prescribed,
            rotors,
            columns,
            closures: None,
            projections: None,
            recorded: None,
        };
        if is_large {
            model.solve_sparsely();
        }
        model
    }

    /// Forces the use of the sparse solver for any number of DOFs. Has no effect on mechanisms with
    /// rotors or gearings, which the sparse solver does not support.
    #[doc(hidden)]
    pub fn solve_sparsely(&mut self) {
        let topology = &self.topology;
        if self.rotors.is_empty() && topology.gearings.is_empty() {
            self.closures = Some(Arc::new(Closures::new(topology, Reach::Roots)));
            self.projections = Some(Arc::new(Closures::new(topology, Reach::Loop)));
        }
    }

    /// Forces the use of the dense solver for any number of DOFs. Tests compare the sparse solver
    /// with the dense solver.
    #[doc(hidden)]
    pub fn solve_densely(&mut self) {
        (self.closures, self.projections) = (None, None);
    }

    /// Returns the mechanism that this model describes.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Returns the topology of the mechanism: spanning tree and cut joints.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Returns the parameters of the mechanism: geometry, inertia and friction.
    pub fn parameters(&self) -> &Parameters<f64> {
        &self.parameters
    }

    /// Assembles the mechanism so that `coordinates` have the values and rates of `targets`.
    /// `initial_poses` are initial guesses of body poses in the ground frame. Returns coordinates
    /// and rates of the spanning tree.
    ///
    /// # Errors
    /// See [`crate::kinematics::AssemblyError`].
    pub fn assemble(
        &self,
        initial_poses: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Result<State<f64>, ForwardError> {
        self.assemble_with_report(initial_poses, coordinates, targets).map(|(state, _)| state)
    }

    /// Assembles the mechanism like [`Self::assemble`], and also compares the assembled
    /// configuration with the given start coordinates and poses.
    ///
    /// # Errors
    /// See [`crate::kinematics::AssemblyError`].
    #[doc(hidden)]
    pub fn assemble_with_report(
        &self,
        initial_poses: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Result<(State<f64>, AssemblyReport), ForwardError> {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let assembly = Assembly::new(
            self.simulated(),
            topology,
            parameters,
            initial_poses,
            coordinates,
            targets,
        )?;
        Ok((assembly.state().clone(), assembly.report().clone()))
    }
}
