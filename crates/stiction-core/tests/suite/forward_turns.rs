//! Angles of joints that close loops are continuous over full turns, for any interval between two
//! rows.

use crate::common::*;
use stiction_core::forward::{Forward, Inputs, Known, Method, Settings, View};
use stiction_core::joint::JointType;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
use stiction_core::topology::TreeRule;

/// Stores the angle that the inputs received.
struct Look(f64);

impl Inputs for Look {
    fn efforts(&mut self, _: &View<'_>, _: &mut [f64]) {}
    fn next_change(&self, time: f64) -> Option<f64> {
        (time < 0.7).then_some(0.7)
    }
    fn change(&mut self, view: &View<'_>) {
        self.0 = view.actuator_coordinate(0);
    }
}

/// A wheel in two bearings, one of which closes a loop: after t seconds, both angles are omega t.
#[test]
fn a_wheel_in_two_bearings_counts_its_turns() {
    const OMEGA: f64 = 1000.0;
    let mechanism = MechanismBuilder::new("wheel")
        .gravity(v(0.0, 0.0, 0.0))
        .body(BodySpec::new("wheel").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(JointSpec::new("left", JointType::Revolute, "ground", "wheel").actuated())
        .joint(JointSpec::new("right", JointType::Revolute, "ground", "wheel"))
        .build()
        .unwrap();
    let left = mechanism.joint_id("left").unwrap();
    let mut cut = 0;
    for (seed, method) in (0..4).flat_map(|s| [(s, Method::EventDriven), (s, Method::TimeStepping)])
    {
        let model = Forward::with_tree(mechanism.clone(), TreeRule::Random(seed), &[]);
        let coordinate = Coordinate::Joint { joint: left, dof: 0 };
        let spins = Known { coordinate, value: Some(0.0), rate: Some(OMEGA) };
        let state = model.assemble_from(&[], &[spins]).unwrap();
        let settings = Settings { method, ..Settings::default() };
        let mut look = Look(f64::NAN);
        let mut simulation = model.start(0.0, state, settings, &mut look).unwrap();
        simulation.advance(1.0, &mut look).unwrap();
        // If the wheel floats in the spanning tree, its orientation is integrated in about 1e3
        // steps, with errors of 1e-10 each (event-driven) or 1e-7 (first order, accumulating). An
        // error of a full turn would be 6.3.
        let far = if method == Method::EventDriven { 1e-6 } else { 0.1 };
        let angle = simulation.joint_motion(left, 0).value;
        assert!((angle - OMEGA).abs() < far, "{method:?}: {angle}");
        assert!((look.0 - 0.7 * OMEGA).abs() < far, "{}", look.0);
        let now = simulation.instant();
        let within = model.joint_coordinate(&now.state, &now.bodies, left, 0);
        cut += usize::from(within.abs() < 4.0);
        let mut resumed = model.resume(&simulation.checkpoint(), settings).unwrap();
        resumed.advance(1.5, &mut look).unwrap();
        let angle = resumed.joint_motion(left, 0).value;
        assert!((angle - 1.5 * OMEGA).abs() < 1.5 * far, "{method:?}: {angle}");
    }
    // About half of the random trees are cut at this bearing.
    assert!(cut > 0 && cut < 8, "{cut}");
}
