//! Forces at one instant, solved with converged friction.

use stiction_core::dynamics::Data;
use stiction_core::parameters::Parameters;

/// Solution of the forces at one instant, with converged friction.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Normal load of each friction interface minus its preload, which represents load-independent
    /// friction, N.
    pub loads: Vec<f64>,
    /// Speed of each friction interface, m/s, with the sign of the velocity's first component.
    pub velocities: Vec<f64>,
}

impl Solved {
    pub(crate) fn of(engine: &Parameters<f64>, data: &Data<f64>) -> Self {
        let preloads = engine.interfaces.iter().map(|own| own.load.preload);
        Self {
            loads: data
                .friction()
                .iter()
                .zip(preloads)
                .map(|(own, preload)| own.load - preload)
                .collect(),
            velocities: data.friction().iter().map(|own| own.velocity).collect(),
        }
    }
}
