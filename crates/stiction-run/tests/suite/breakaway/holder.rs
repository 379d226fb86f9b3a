//! Mechanism at rest with prescribed static friction forces.

use crate::common::*;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Rest, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::ModelFile;

/// Mechanism at rest whose static friction at every interface is a given fraction of its limit.
pub(crate) struct Holder {
    pub(crate) solver: InverseDynamics,
    pub(crate) loads: Vec<AppliedLoad<f64>>,
    targets: Vec<Target<f64>>,
    pub(crate) rest: Rest,
}

impl Holder {
    /// Creates the mechanism at an instant of a model's default motion.
    pub(crate) fn new(model: &ModelFile, time: f64) -> Self {
        let job = default_job(model, FrictionMode::Converged);
        let (coordinates, targets): (Vec<Coordinate>, Vec<Target<f64>>) = job
            .motion
            .coordinates
            .iter()
            .map(|(c, signal)| (*c, Target { rate: 0.0, acceleration: 0.0, ..signal.at(time) }))
            .unzip();
        let loads: Vec<_> = job.load.at(time).collect();
        let mechanism = model.mechanism.clone();
        let settings = Settings::default();
        let mut solver =
            InverseDynamics::new(mechanism, &model.initial_poses, &coordinates, &targets, settings)
                .unwrap();
        let rest = solver.rest(&loads).unwrap();
        Self { solver, loads, targets, rest }
    }

    pub(crate) fn drives(&self, held: &[[f64; 3]]) -> Option<Vec<f64>> {
        self.balance(held).map(|(drives, _)| drives)
    }

    /// Computes the actuator forces and the normal loads for the static friction `held`, as
    /// fractions of the limits. `None` if friction and reactions do not converge.
    pub(crate) fn balance(&self, held: &[[f64; 3]]) -> Option<(Vec<f64>, Vec<f64>)> {
        let compiled = self.solver.model().unwrap();
        let parameters = self.solver.parameters();
        let settings = Settings::default();
        let mut data = compiled.data(self.solver.state(), settings);
        for (interface, held) in held.iter().enumerate() {
            data.inverse.set_static_friction(interface, *held);
        }
        compiled.evaluate(parameters, &mut data, &self.targets, &self.loads);
        let inverse = &data.inverse;
        let loads = inverse.interfaces().iter().map(|interface| interface.load()).collect();
        inverse.friction_settled(&settings).then(|| (inverse.efforts().to_vec(), loads))
    }
}
