//! Motions that are driven without bound end soon, with a stated reason.

use crate::common::*;
use stiction_core::forward::{Forward, ForwardError, Inputs, Settings, View};
use stiction_core::joint::JointType;
use stiction_core::kinematics::State;
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};

/// Applies a torque that grows by a factor of one hundred every 5 ms.
struct Growing;

impl Inputs for Growing {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        efforts[0] = (1000.0 * view.time).exp();
    }
}

/// From rest, `I omega = (exp(k t) - 1) / k`. At a distance of `1 m`, the speed of light is
/// exceeded at `t = ln(1 + k I c / L) / k`.
#[test]
fn unbounded_speed_ends_the_run() {
    let mechanism = MechanismBuilder::new("spin")
        .gravity(v(0.0, 0.0, 0.0))
        .characteristic_length(1.0)
        .body(BodySpec::new("wheel").mass(1.0).inertia(diagonal(1.0, 1.0, 1.0)))
        .joint(JointSpec::new("pin", JointType::Revolute, "ground", "wheel").actuated())
        .build()
        .unwrap();
    let forward = Forward::new(mechanism, &[]);
    let state = State::new(forward.topology());
    let mut simulation = forward.start(0.0, state, Settings::default(), &mut Growing).unwrap();
    let error = simulation.advance(1.0, &mut Growing).unwrap_err();
    let ForwardError::Runaway { time, body, speed } = error else { panic!("{error}") };
    let overtaken = (1.0_f64 + 1000.0 * 299_792_458.0).ln() / 1000.0;
    // The simulation reports this at the end of a step. Within the step, the torque grows by less
    // than a factor of ten.
    assert!(time >= overtaken && time < overtaken + 2.4e-3, "{time} {overtaken}");
    assert!(body == "wheel" && speed > 299_792_458.0, "{body} {speed}");
}
