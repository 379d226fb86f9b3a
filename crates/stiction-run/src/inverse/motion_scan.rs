//! The motion alone: whether it can be followed, how fast contacts slide, what constraints leave.

use super::chunks::Work;
use super::error::Error;
use super::uniqueness::is_determined;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::parameters::InterfaceParameters;
use stiction_core::statics::{Constraints, SingularityDistances};

/// Follows the motion alone.
pub(super) struct Following {
    /// Samples at which freedoms are counted.
    pub(super) mobility_at: [usize; 3],
}

/// How fast contacts slide, and how many freedoms the constraints leave.
pub(super) struct Pace {
    /// m/s.
    pub(super) fastest: f64,
    pub(super) mobility: usize,
}

impl Pace {
    /// Of no sample.
    pub(super) fn none() -> Self {
        Self { fastest: 0.0, mobility: usize::MAX }
    }

    /// Of these samples and others.
    pub(super) fn add(&mut self, other: Self) {
        self.fastest = self.fastest.max(other.fastest);
        self.mobility = self.mobility.min(other.mobility);
    }
}

impl Work for Following {
    type Piece = Pace;

    fn begin(&self) -> Pace {
        Pace::none()
    }

    fn look(
        &self,
        pace: &mut Pace,
        solver: &mut InverseDynamics,
        sample: usize,
        _time: f64,
    ) -> Result<(), Error> {
        let mobility = match self.mobility_at.contains(&sample) {
            true => mobility(solver),
            false => usize::MAX,
        };
        pace.add(Pace { fastest: fastest_interface(solver), mobility });
        Ok(())
    }
}

/// Constraints further than this from being dependent are independent, whatever a rank is decided by.
const INDEPENDENT: f64 = 1e-8;

/// How many freedoms the constraints leave at the present position. Where they are independent, which products of
/// sparse matrices can tell, these are the driven ones.
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

/// The fastest sliding speed of any contact at the present motion, m/s.
fn fastest_interface(solver: &InverseDynamics) -> f64 {
    let (topology, bodies) = (solver.topology(), solver.bodies());
    let speed = |interface: &InterfaceParameters<f64>| {
        let pitch = solver.parameters().pitch[interface.joint];
        let velocity = bodies.surface_velocity(topology, interface, pitch);
        velocity.iter().map(|v| v * v).sum::<f64>().sqrt()
    };
    solver.parameters().interfaces.iter().map(speed).fold(0.0, f64::max)
}
