//! Forward dynamics: what a mechanism does under given forces, with joints that stick and slip.
//!
//! Accelerations and all reactions come together from one linear system (index 1); friction, bounded by
//! each joint's own reaction, is coupled to it implicitly. Whether a contact at rest sticks is decided
//! among the accelerations; one that sticks does not move at all. See [`Forward`] and [`Simulation`].

mod balance;
mod cone;
mod coupling;
mod dead;
mod dop853;
mod error;
mod ground;
mod guess;
mod initial;
mod inputs;
mod instant;
mod integrator;
mod joints;
mod leap;
mod masses;
mod project;
mod rows;
mod rub;
mod simulation;
mod solve;
mod stick;
mod surface;

pub use error::{Competitor, ForwardError};
pub use initial::Known;
pub use inputs::{ConstantEfforts, Inputs, View};
pub use instant::{Account, ContactMoment, Instant};
pub use rub::Contact;
pub use simulation::{Checkpoint, Energies, Event, EventKind, Method, Settings, Simulation};

use crate::kinematics::{Assembly, Coordinate, State, Target};
use crate::mechanism::{BodyId, Mechanism};
use crate::parameters::Parameters;
use crate::spatial::Pose;
use crate::topology::{Topology, TreeRule};

/// A mechanism, ready to be simulated.
#[derive(Clone, Debug)]
pub struct Forward {
    mechanism: Mechanism,
    topology: Topology,
    parameters: Parameters<f64>,
    /// Actuators whose motion is prescribed.
    prescribed: Vec<usize>,
    /// For each freedom of the tree the characteristic length where it translates, else one.
    columns: Vec<f64>,
}

impl Forward {
    /// `prescribed` are the indices of actuators whose coordinate is a given function of time; all
    /// others exert efforts.
    pub fn new(mechanism: Mechanism, prescribed: &[usize]) -> Self {
        Self::with_tree(mechanism, TreeRule::Structure, prescribed)
    }

    /// The same with a tree chosen by `rule`.
    pub fn with_tree(mechanism: Mechanism, rule: TreeRule, prescribed: &[usize]) -> Self {
        let topology = Topology::with_tree(&mechanism, rule);
        let parameters = Parameters::new(&mechanism);
        let length = parameters.length;
        let translates = |dof| topology.dof_translates(dof);
        let columns =
            topology.dofs.iter().map(|dof| if translates(dof) { length } else { 1.0 }).collect();
        let known = 0..topology.actuators.len();
        let prescribed = prescribed.iter().copied().filter(|a| known.contains(a)).collect();
        Self { mechanism, topology, parameters, prescribed, columns }
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

    /// Coordinates and rates of the tree where `coordinates` have these values and rates; `homes` are
    /// guesses of the poses of bodies in the ground's frame.
    ///
    /// # Errors
    /// See [`crate::kinematics::AssemblyError`].
    pub fn assemble(
        &self,
        homes: &[(BodyId, Pose<f64>)],
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Result<State<f64>, ForwardError> {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let assembly =
            Assembly::new(&self.mechanism, topology, parameters, homes, coordinates, targets)?;
        Ok(assembly.state().clone())
    }
}
