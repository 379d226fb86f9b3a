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
    let settings = Settings { friction: FrictionMode::Off, position_steps, ..Settings::default() };
    let mut data = model.data(like, settings);
    data.state.coordinates.copy_from_slice(coordinates);
    model.evaluate(parameters, &mut data, targets, loads);
    data
}

/// Changes of forces due to a unit acceleration of one prescribed coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Inertial<T> {
    /// Change of each actuator force.
    pub(crate) drives: Vec<T>,
    /// Change of each joint's total wrench.
    pub(crate) wrenches: Vec<Wrench<T>>,
}

impl<T: Scalar> Inertial<T> {
    /// Evaluates the changes due to unit accelerations of all prescribed coordinates, one after the
    /// other, at one position with zero rates, without gravity, springs, bushings and external
    /// loads.
    pub(crate) fn all(
        model: &Model,
        parameters: &Parameters<T>,
        like: &State<f64>,
        coordinates: &[T],
        targets: &[Target<T>],
    ) -> Vec<Self> {
        let mut inert = parameters.clone();
        inert.gravity = Vec3::zero();
        inert.springs.clear();
        inert.joint_springs.clear();
        inert.bushings.clear();
        (0..targets.len())
            .map(|unit| {
                let mut own = targets.to_vec();
                for (k, target) in own.iter_mut().enumerate() {
                    target.rate = T::zero();
                    target.acceleration = if k == unit { T::one() } else { T::zero() };
                }
                let ran = run(model, &inert, like, coordinates, (&own, &[]), 0);
                let inverse: &Inverse<T> = &ran.inverse;
                Self {
                    drives: inverse.efforts().to_vec(),
                    wrenches: inverse.joint_wrenches().to_vec(),
                }
            })
            .collect()
    }
}
