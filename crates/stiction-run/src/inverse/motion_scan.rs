//! Scan of the motion before forces are computed: feasibility, sliding speeds and mobility.

use super::chunks::Work;
use super::track::Track;
use super::uniqueness::is_determined;
use crate::error::Error;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::parameters::InterfaceParameters;
use stiction_core::statics::{Constraints, SingularityDistances};

/// Evaluates the chunks of a motion without computing forces.
pub(super) struct Following {
    /// Indices of the samples at which the mobility is computed.
    pub(super) mobility_at: [usize; 3],
}

/// Largest rates and least mobility along a motion.
pub(super) struct MotionExtremes {
    /// Largest sliding speed of any friction interface, m/s.
    pub(super) fastest: f64,
    /// Largest rate of each actuator, m/s or rad/s; empty before the first sample.
    pub(super) actuators: Vec<f64>,
    pub(super) mobility: usize,
    /// Configurations at the first samples of the motion, up to the largest number that a [`Track`]
    /// stores.
    pub(super) track: Track,
}

impl MotionExtremes {
    /// Returns the result for an empty set of samples.
    pub(super) fn none() -> Self {
        let (actuators, track) = (Vec::new(), Track::default());
        Self { fastest: 0.0, actuators, mobility: usize::MAX, track }
    }

    /// Adds the results `other` of samples that follow those already included.
    pub(super) fn add(&mut self, other: Self) {
        self.fastest = self.fastest.max(other.fastest);
        self.mobility = self.mobility.min(other.mobility);
        self.actuators.resize(self.actuators.len().max(other.actuators.len()), 0.0);
        for (own, other) in self.actuators.iter_mut().zip(other.actuators) {
            *own = own.max(other);
        }
        self.track.append(&other.track);
    }
}

impl Work for Following {
    type Piece = MotionExtremes;

    fn begin(&self) -> MotionExtremes {
        MotionExtremes::none()
    }

    fn evaluate(
        &self,
        extremes: &mut MotionExtremes,
        solver: &mut InverseDynamics,
        sample: usize,
        _time: f64,
    ) -> Result<(), Error> {
        let mobility = match self.mobility_at.contains(&sample) {
            true => mobility(solver),
            false => usize::MAX,
        };
        let actuators = match solver.mechanism().drive_trains() {
            [] => Vec::new(),
            _ => solver.actuator_rates().map(f64::abs).collect(),
        };
        let fastest = fastest_interface(solver);
        extremes.add(MotionExtremes { fastest, actuators, mobility, ..MotionExtremes::none() });
        extremes.track.add(solver);
        Ok(())
    }
}

/// Constraint singularity index above which the constraints count as independent.
const INDEPENDENT: f64 = 1e-8;

/// Returns the mobility at the present pose. If the constraint singularity index, which is fast to
/// compute, proves that the constraints are independent, the mobility is the number of actuators,
/// which then equals the number of prescribed coordinates.
fn mobility(solver: &InverseDynamics) -> usize {
    let mechanism = solver.mechanism();
    if is_determined(solver)
        && let Some(mut proximity) = SingularityDistances::new(mechanism)
        && proximity.measure(mechanism, solver.parameters(), solver.bodies()).constraint
            > INDEPENDENT
    {
        return mechanism.actuators().count();
    }
    Constraints::new(&solver.statics()).mobility()
}

/// Returns the largest sliding speed of all friction interfaces in the present state, m/s.
fn fastest_interface(solver: &InverseDynamics) -> f64 {
    let (topology, bodies) = (solver.topology(), solver.bodies());
    let speed = |interface: &InterfaceParameters<f64>| {
        let pitch = solver.parameters().pitch[interface.joint];
        let velocity = bodies.surface_velocity(topology, interface, pitch);
        velocity.iter().map(|v| v * v).sum::<f64>().sqrt()
    };
    solver.parameters().interfaces.iter().map(speed).fold(0.0, f64::max)
}
