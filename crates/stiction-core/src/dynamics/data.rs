//! State and results of a compiled model, and the generic inverse-dynamics computation for any
//! scalar type.

use super::forces::Forces;
use super::inverse::Inverse;
use super::model::Model;
use super::settings::Settings;
use crate::kinematics::{Kinematics, State, Target};
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::statics::AppliedLoad;

/// State and results of a computation with a [`Model`], allocated once by [`Model::data`].
#[derive(Clone, Debug)]
pub struct Data<T> {
    /// Coordinates, rates and accelerations of the spanning tree. The next computation starts from
    /// these coordinates.
    pub state: State<T>,
    /// Motion of all bodies.
    pub kinematics: Kinematics<T>,
    /// Efforts, reactions and friction forces of the last computation.
    pub inverse: Inverse<T>,
    /// Friction mode, tolerances and iteration limits.
    pub settings: Settings,
    /// Last configuration at which the loops were closed.
    pub(super) closed: State<T>,
    pub(super) targets: Vec<Target<T>>,
    pub(super) forces: Forces,
}

impl Model {
    /// Allocates data for this model. The first computation starts from the configuration `state`
    /// of the spanning tree.
    ///
    /// # Panics
    /// If `state` belongs to another spanning tree.
    pub fn data<T: Scalar>(&self, state: &State<f64>, settings: Settings) -> Data<T> {
        let (topology, constraints) = (self.topology(), self.constraints());
        assert_eq!(
            state.coordinates.len(),
            topology.coordinates(),
            "the state belongs to another spanning tree"
        );
        let state = state.lift();
        Data {
            closed: state.clone(),
            state,
            kinematics: Kinematics::new(topology, constraints, &self.kinematic.rates),
            inverse: Inverse::new(self),
            settings,
            targets: vec![Target::AT_ZERO.lift(); constraints.coordinates().len()],
            forces: Forces::new(
                [
                    topology.actuators.len(),
                    self.mechanism.joints().len(),
                    self.mechanism.gearings().len(),
                ],
                self.parameters.interfaces.len(),
            ),
        }
    }

    /// Computes the inverse dynamics for any scalar type: all efforts and reactions for prescribed
    /// motions, one target for each coordinate, and external loads.
    ///
    /// Takes [`Settings::position_steps`] Newton steps from the configuration in `data`, then
    /// solves for rates, accelerations, reactions and friction. This method neither allocates
    /// memory nor branches on values, and it performs no checks: use [`Kinematics::largest_error`],
    /// [`Inverse::friction_change`] and [`Inverse::orientation`] afterwards, or call
    /// [`Self::inverse_dynamics`] instead.
    pub fn evaluate<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        data: &mut Data<T>,
        targets: &[Target<T>],
        loads: &[AppliedLoad<T>],
    ) {
        let Data { state, kinematics, inverse, settings, .. } = data;
        for _ in 0..settings.position_steps {
            kinematics.approach(&self.kinematic, parameters, state, targets);
        }
        kinematics.differentiate(&self.kinematic, parameters, state, targets);
        inverse.solve(self, parameters, kinematics, loads, settings);
    }

    /// Computes rates and accelerations for prescribed motions, one target for each coordinate, at
    /// the configuration in `data`, which must close the loops. Computes no forces.
    pub fn differentiate<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        data: &mut Data<T>,
        targets: &[Target<T>],
    ) {
        let Data { state, kinematics, .. } = data;
        kinematics.differentiate(&self.kinematic, parameters, state, targets);
    }

    /// Computes efforts and reactions for the given accelerations of the spanning tree, with the
    /// configuration and rates of the last [`Self::differentiate`] or [`Self::evaluate`]. The
    /// accelerations need not be possible with closed loops: forces depend on them in an affine
    /// way, so that those of possible accelerations are sums of those of single accelerations. The
    /// state in `data` receives the accelerations, one for each degree of freedom of the tree.
    ///
    /// # Panics
    /// If the number of accelerations differs from that of the tree's degrees of freedom.
    pub fn forces<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        data: &mut Data<T>,
        accelerations: &[T],
        loads: &[AppliedLoad<T>],
    ) {
        let Data { state, kinematics, inverse, settings, .. } = data;
        state.accelerations.copy_from_slice(accelerations);
        kinematics.bodies.accelerate(self.topology(), accelerations);
        inverse.solve(self, parameters, kinematics, loads, settings);
    }

    /// Takes one Newton step towards closed loops and prescribed values, for any scalar type.
    /// [`Kinematics::scaled_errors`] returns the errors before the step.
    pub fn approach<T: Scalar>(
        &self,
        parameters: &Parameters<T>,
        data: &mut Data<T>,
        targets: &[Target<T>],
    ) {
        let Data { state, kinematics, .. } = data;
        kinematics.approach(&self.kinematic, parameters, state, targets);
    }

    /// Returns the reciprocal pivots of the rate equations after [`Self::evaluate`]. Their product
    /// never vanishes, and grows without bound near configurations at which the prescribed
    /// coordinates do not determine the motion.
    #[doc(hidden)]
    pub fn rate_pivots<T: Scalar>(&self, data: &Data<T>) -> Vec<T> {
        data.kinematics.reciprocal_pivots(&self.kinematic)
    }
}
