//! Inverse kinematics and inverse dynamics in one call, over any scalar.

use super::inverse::Inverse;
use super::plan::BalancePlan;
use super::settings::Settings;
use super::setup::Setup;
use crate::kinematics::{Kinematics, MotionConstraints, State, Target};
use crate::linalg::StaticLu;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::statics::AppliedLoad;
use crate::topology::Topology;

/// A mechanism compiled for one prescription near one position. Immutable; the numbers are in
/// [`Parameters`], all that changes is in a [`Workspace`].
#[derive(Clone, Debug)]
pub struct Kernel {
    topology: Topology,
    motion_constraints: MotionConstraints,
    motion: StaticLu,
    balance: BalancePlan,
}

/// Everything that a kernel reads and writes. Allocated once.
#[derive(Clone, Debug)]
pub struct Workspace<T> {
    /// Coordinates, rates and accelerations of the tree. A run starts from its coordinates.
    pub state: State<T>,
    /// Motion of all bodies.
    pub kinematics: Kinematics<T>,
    /// Drives, reactions, friction.
    pub inverse: Inverse<T>,
}

impl Kernel {
    /// A copy of what a driver compiled.
    pub fn new(setup: &Setup<'_>) -> Self {
        Self {
            topology: setup.topology.clone(),
            motion_constraints: setup.motion_constraints.clone(),
            motion: setup.motion.clone(),
            balance: setup.balance.clone(),
        }
    }

    /// The graph.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The parts.
    pub fn setup(&self) -> Setup<'_> {
        Setup {
            topology: &self.topology,
            motion_constraints: &self.motion_constraints,
            motion: &self.motion,
            balance: &self.balance,
        }
    }

    /// Multiply-subtract operations of the two factorisations, of rates and of the balance: what
    /// grows with the structure of a mechanism.
    pub fn operations(&self) -> (usize, usize) {
        (self.motion.operations(), self.balance.operations())
    }

    /// Room for runs that start at `state`.
    pub fn workspace<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        state: &State<f64>,
    ) -> Workspace<T> {
        let lift = |numbers: &[f64]| numbers.iter().map(|&x| T::from_f64(x)).collect();
        Workspace {
            state: State {
                coordinates: lift(&state.coordinates),
                rates: lift(&state.rates),
                accelerations: lift(&state.accelerations),
            },
            kinematics: Kinematics::new(&self.topology, &self.motion_constraints, &self.motion),
            inverse: Inverse::new(&self.setup(), parameters),
        }
    }

    /// From prescribed values and loads to all forces: [`Settings::position_steps`] Newton steps
    /// from the position in `workspace`, exact rates and accelerations, all reactions.
    ///
    /// Nothing is checked in here; look at [`Kinematics::largest_error`],
    /// [`Inverse::friction_change`] and [`Inverse::orientation`] afterwards.
    pub fn run<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        workspace: &mut Workspace<T>,
        targets: &[Target<T>],
        loads: &[AppliedLoad<T>],
        settings: &Settings,
    ) {
        let Workspace { state, kinematics, inverse } = workspace;
        let (topology, motion_constraints, motion) =
            (&self.topology, &self.motion_constraints, &self.motion);
        for _ in 0..settings.position_steps {
            kinematics.approach(topology, parameters, motion_constraints, motion, state, targets);
        }
        kinematics.differentiate(topology, parameters, motion_constraints, motion, state, targets);
        inverse.solve(&self.setup(), parameters, kinematics, loads, settings);
    }
}
