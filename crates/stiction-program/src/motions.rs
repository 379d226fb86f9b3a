//! Changes of actuator forces and joint wrenches per unit acceleration of the prescribed
//! coordinates.

use stiction_core::dynamics::{AppliedLoad, Data, FrictionMode, Inverse, Model, Settings};
use stiction_core::kinematics::{State, Target};
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Vec3, Wrench};

/// Evaluates inverse dynamics without friction, after `position_steps` position corrections that
/// start from the given coordinates.
// Not inlined: the kernel is large and slow to compile.
#[inline(never)]
pub(crate) fn run<T: Scalar>(
    model: &Model,
    parameters: &Parameters<T>,
    like: &State<f64>,
    coordinates: &[T],
    (targets, loads): (&[Target<T>], &[AppliedLoad<T>]),
    position_steps: usize,
) -> Data<T> {
    let mut data = begin(model, like, coordinates, position_steps);
    model.evaluate(parameters, &mut data, targets, loads);
    data
}

/// Changes of accelerations and forces due to unit accelerations, at one position.
///
/// A degree of freedom of the spanning tree accelerates only the bodies behind it, so that forces
/// are recorded with few operations for each of these degrees of freedom, and combined for the
/// prescribed coordinates.
#[derive(Clone, Debug)]
pub(crate) struct UnitAccelerations<T> {
    /// For each prescribed coordinate, the accelerations of the tree's degrees of freedom.
    pub(crate) tree: Vec<Vec<T>>,
    /// For each degree of freedom of the tree, the changes of all forces at fixed accelerations of
    /// all others.
    pub(crate) forces: Vec<Inertial<T>>,
}

/// Changes of forces due to a unit acceleration.
#[derive(Clone, Debug)]
pub(crate) struct Inertial<T> {
    /// Change of each actuator force.
    pub(crate) drives: Vec<T>,
    /// Change of each joint's total wrench.
    pub(crate) wrenches: Vec<Wrench<T>>,
}

impl<T: Scalar> UnitAccelerations<T> {
    /// Evaluates the changes with zero rates, without gravity, springs, bushings and external
    /// loads.
    pub(crate) fn new(
        model: &Model,
        parameters: &Parameters<T>,
        like: &State<f64>,
        coordinates: &[T],
        targets: &[Target<T>],
    ) -> Self {
        let mut inert = parameters.clone();
        inert.gravity = Vec3::zero();
        inert.springs.clear();
        inert.joint_springs.clear();
        inert.bushings.clear();
        let unit = |is_one: bool| if is_one { T::one() } else { T::zero() };
        let mut data = begin(model, like, coordinates, 0);
        let tree = (0..targets.len()).map(|coordinate| {
            let at = |(k, target): (usize, &Target<T>)| Target {
                rate: T::zero(),
                acceleration: unit(k == coordinate),
                ..*target
            };
            let targets: Vec<Target<T>> = targets.iter().enumerate().map(at).collect();
            model.differentiate(&inert, &mut data, &targets);
            data.state.accelerations.clone()
        });
        let tree = tree.collect();
        let count = like.accelerations.len();
        let forces = (0..count).map(|dof| {
            let accelerations: Vec<T> = (0..count).map(|k| unit(k == dof)).collect();
            model.forces(&inert, &mut data, &accelerations, &[]);
            let inverse: &Inverse<T> = &data.inverse;
            Inertial {
                drives: inverse.efforts().to_vec(),
                wrenches: inverse.joint_wrenches().to_vec(),
            }
        });
        Self { tree, forces: forces.collect() }
    }

    /// Accelerations of the tree for given accelerations of the prescribed coordinates, without
    /// those due to rates.
    pub(crate) fn of_tree(&self, accelerations: &[T]) -> Vec<T> {
        let sum = |dof: usize| {
            let parts = self.tree.iter().zip(accelerations);
            parts.fold(T::zero(), |sum, (unit, amount)| sum + unit[dof] * *amount)
        };
        (0..self.forces.len()).map(sum).collect()
    }

    /// Sums of `amounts`, one for each degree of freedom of the tree, for unit accelerations of
    /// each prescribed coordinate.
    pub(crate) fn of_targets(&self, amounts: &[T]) -> Vec<T> {
        let sum = |unit: &Vec<T>| {
            unit.iter().zip(amounts).fold(T::zero(), |sum, (unit, amount)| sum + *unit * *amount)
        };
        self.tree.iter().map(sum).collect()
    }

    /// Matrix of actuator forces (rows) per unit acceleration of each prescribed coordinate
    /// (columns).
    pub(crate) fn masses(&self, drives: usize) -> Vec<Vec<T>> {
        let row = |drive: usize| {
            let amounts: Vec<T> = self.forces.iter().map(|forces| forces.drives[drive]).collect();
            self.of_targets(&amounts)
        };
        (0..drives).map(row).collect()
    }
}

/// Data at the given coordinates, for evaluations without friction.
fn begin<T: Scalar>(
    model: &Model,
    like: &State<f64>,
    coordinates: &[T],
    position_steps: usize,
) -> Data<T> {
    let settings = Settings { friction: FrictionMode::Off, position_steps, ..Settings::default() };
    let mut data = model.data(like, settings);
    data.state.coordinates.copy_from_slice(coordinates);
    data
}
