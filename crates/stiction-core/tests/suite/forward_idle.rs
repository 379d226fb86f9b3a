//! Local DOFs: spins of rods between balls, without inertia about the axis of the rod.

use crate::common::*;
use stiction_core::forward::{ConstantEfforts, Forward, ForwardError, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::State;
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
use stiction_core::spatial::{Pose, Vec3};

/// Creates a point mass on a massless rod between two balls; the rod is horizontal, towards -x.
fn pendulum(mu: f64) -> Forward {
    let low = Pose::at(v(-1.0, 0.0, 0.0));
    let mut upper = JointSpec::new("upper", JointType::Spherical, "ground", "rod");
    if mu > 0.0 {
        upper = upper.friction(friction(mu, 0.0, Some(0.01)));
    }
    let mechanism = MechanismBuilder::new("pendulum")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("rod"))
        .body(BodySpec::new("bob").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(upper)
        .joint(
            JointSpec::new("lower", JointType::Spherical, "rod", "bob")
                .frames(low, Pose::identity()),
        )
        .build()
        .unwrap();
    Forward::new(mechanism, &[])
}

/// Reference R1 on such a rod: no torque acts on the spin, so the spin must not cause a failure,
/// neither at rest nor at a constant rate.
#[test]
fn a_rod_without_inertia_keeps_its_spin() {
    let model = pendulum(0.0);
    for spin in [0.0, 3.0] {
        let mut state = State::new(model.topology());
        // Spin about x, the rod's own axis; the bob does not turn with the rod.
        state.rates[0] = spin;
        state.rates[3] = -spin;
        let mut inputs = ConstantEfforts(vec![]);
        let settings = Settings { relative: 1e-12, absolute: 1e-13, ..Settings::default() };
        let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
        for (time, x, y) in [
            (1.0, 0.9862917511319, -0.1650108531255),
            (5.0, -0.9423054350438, -0.334754338414),
            (10.0, -0.2750874625761, -0.9614192050991),
        ] {
            simulation.advance(time, &mut inputs).unwrap();
            let now = simulation.instant();
            let bob = now.bodies.frame_k[1].position + model.parameters().origin;
            assert!((bob - v(x, y, 0.0)).norm() < 1e-9, "{spin} {time}: {bob:?}");
            let rod = model.mechanism().body_id("rod").unwrap().0;
            let axis: Vec3<f64> = now.bodies.pose[rod].rotation * Vec3::unit(0);
            let rate = now.bodies.twist[rod].angular.dot(axis);
            assert!((rate - spin).abs() < 1e-8, "{rate}");
        }
        assert!(simulation.energy_error().abs() < 1e-9);
    }
}

/// Friction acts on the spin, which has no inertia: the acceleration is undefined, and the error
/// must name the body.
#[test]
fn friction_on_a_rod_without_inertia_is_reported() {
    let model = pendulum(0.2);
    let mut state = State::new(model.topology());
    (state.rates[0], state.rates[3]) = (3.0, -3.0);
    let mut inputs = ConstantEfforts(vec![]);
    let settings = Settings::default();
    let error = model.start(0.0, state, settings, &mut inputs).map(|_| ()).unwrap_err();
    assert!(matches!(&error, ForwardError::Massless { body, .. } if body == "rod"), "{error}");
}
