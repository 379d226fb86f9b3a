//! Parts picked up and placed during a simulation: momentum, lost energy, energy balance.

use stiction_core::forward::{
    EventKind, Forward, Inputs, Method, PayloadChange, Settings, Simulation, View,
};
use stiction_core::friction::{JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{
    Body, BodyId, BodySpec, JointId, JointSpec, Mechanism, MechanismBuilder,
};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Applies no efforts; a step ends at the given time.
struct ChangeAt(f64);

impl Inputs for ChangeAt {
    fn efforts(&mut self, _: &View<'_>, _: &mut [f64]) {}

    fn next_change(&self, time: f64) -> Option<f64> {
        Some(self.0).filter(|change| *change > time)
    }
}

fn part(mass: f64, com: Vec3<f64>, inertia: f64) -> Body {
    let spec = BodySpec::new("part")
        .mass(mass)
        .com(com)
        .inertia(Mat3::diagonal(Vec3::new(inertia, inertia, inertia)));
    let alone = MechanismBuilder::new("part")
        .body(spec)
        .joint(JointSpec::new("free", JointType::Free, "ground", "part"))
        .build()
        .unwrap();
    alone.bodies()[1].clone()
}

fn settings(method: Method) -> Settings {
    Settings { method, ..Settings::default() }
}

/// Creates a block on a rail along x; gravity presses the block onto the rail.
fn block(mu: f64) -> Mechanism {
    let x = Vec3::new(1.0, 0.0, 0.0);
    let rail = Pose { rotation: Mat3::between(Vec3::new(0.0, 0.0, 1.0), x), ..Pose::identity() };
    MechanismBuilder::new("block")
        .gravity(Vec3::new(0.0, -10.0, 0.0))
        .body(BodySpec::new("block").mass(2.0))
        .joint(
            JointSpec::new("rail", JointType::Prismatic, "ground", "block")
                .frames(rail, rail)
                .friction(JointFriction::guide(Law::coulomb_viscous(mu, 0.0))),
        )
        .build()
        .unwrap()
}

fn start<'a>(model: &'a Forward, rate: f64, method: Method) -> Simulation<'a> {
    let coordinate = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let target = Target { value: 0.0, rate, acceleration: 0.0 };
    let state = model.assemble(&[], &[coordinate], &[target]).unwrap();
    model.start(0.0, state, settings(method), &mut ChangeAt(0.5)).unwrap()
}

/// A block of 2 kg at 3 m/s picks up a part of 1 kg: the speed falls to 2 m/s, and 3 J are lost.
/// Friction decelerates at 0.1 x 10 m/s^2 = 1 m/s^2 before and after. Then the block places the
/// part without a change of its own speed.
#[test]
fn a_sliding_block_picks_up_and_places_a_part() {
    for method in [Method::Automatic, Method::EventDriven, Method::TimeStepping] {
        let bare = block(0.1);
        let part = part(1.0, Vec3::new(0.0, 0.0, 0.0), 0.0);
        let loaded = bare.with_payload(BodyId(1), &part);
        let (bare, loaded) = (Forward::new(bare, &[]), Forward::new(loaded, &[]));
        let mut simulation = start(&bare, 3.5, method);
        let mut inputs = ChangeAt(0.5);
        let change = PayloadChange { body: BodyId(1), part: &part, picked_up: true };
        simulation.advance(0.5, &mut inputs).unwrap();
        simulation.change_payload(&loaded, change, &mut inputs).unwrap();
        // Time stepping is of first order in its adapted steps.
        let small = if method == Method::TimeStepping { 1e-5 } else { 1e-9 };
        let rate = |s: &Simulation<'_>| s.joint_motion(JointId(0), 0).rate;
        assert!((rate(&simulation) - 2.0).abs() < small, "{method:?} {}", rate(&simulation));
        assert!((simulation.energies().impacts - 3.0).abs() < 10.0 * small);
        let (force, _) = simulation.instant().reactions()[0];
        assert!((force.y - 30.0).abs() < 1e-6, "{method:?} {force:?}");
        let mut inputs = ChangeAt(1.0);
        simulation.advance(1.0, &mut inputs).unwrap();
        assert!((rate(&simulation) - 1.5).abs() < small);
        let change = PayloadChange { picked_up: false, ..change };
        simulation.change_payload(&bare, change, &mut inputs).unwrap();
        assert!((rate(&simulation) - 1.5).abs() < small);
        simulation.advance(3.0, &mut inputs).unwrap();
        assert_eq!(rate(&simulation), 0.0, "{method:?}");
        assert!(simulation.energy_error().abs() < 20.0 * small, "{}", simulation.energy_error());
        // The placed part takes its kinetic energy along, at the height of the rail.
        assert!((simulation.energies().payloads + 0.5 * 1.5 * 1.5).abs() < 10.0 * small);
        let events = simulation.events().iter();
        let changes = events.filter(|event| matches!(event.kind, EventKind::Payload { .. }));
        assert_eq!(changes.map(|event| event.time).collect::<Vec<_>>(), [0.5, 1.0]);
    }
}

/// A pendulum of inertia I about its pivot catches a part of mass m and inertia J at the distance
/// d, in its lowest position. Without friction, the rate falls by the factor I / (I + m d^2 + J);
/// the impulse of dry friction at the pin reduces it further.
#[test]
fn a_pendulum_catches_a_part() {
    let (mass, arm, inertia, m, d, j) = (2.0, 0.3, 0.05, 0.7, 0.5, 0.02);
    let whole = inertia + mass * arm * arm;
    let after = whole + m * d * d + j;
    for mu in [0.0, 0.2] {
        let radius = 0.01;
        let pendulum = MechanismBuilder::new("pendulum")
            .gravity(Vec3::zero())
            .body(
                BodySpec::new("rod")
                    .mass(mass)
                    .com(Vec3::new(arm, 0.0, 0.0))
                    .inertia(Mat3::diagonal(Vec3::new(inertia, inertia, inertia))),
            )
            .joint(
                JointSpec::new("pin", JointType::Revolute, "ground", "rod")
                    .friction(JointFriction::round(radius, Law::coulomb_viscous(mu, 0.0))),
            )
            .build()
            .unwrap();
        let part = part(m, Vec3::new(d, 0.0, 0.0), j);
        let loaded = Forward::new(pendulum.with_payload(BodyId(1), &part), &[]);
        let bare = Forward::new(pendulum, &[]);
        let mut simulation = start(&bare, 2.0, Method::Automatic);
        let mut inputs = ChangeAt(0.1);
        simulation.advance(0.1, &mut inputs).unwrap();
        let rate = |s: &Simulation<'_>| s.joint_motion(JointId(0), 0).rate;
        let before = rate(&simulation);
        let change = PayloadChange { body: BodyId(1), part: &part, picked_up: true };
        simulation.change_payload(&loaded, change, &mut inputs).unwrap();
        let now = rate(&simulation);
        // Perpendicular to the rod, the pin carries the change of momentum of rod and part; along
        // the rod it carries nothing.
        let impulse = (mass * arm * (now - before) + m * d * now).abs();
        let pivot = mu * radius * impulse;
        assert!((after * now - (whole * before - pivot)).abs() < 1e-9, "{mu}: {now}");
        assert!(simulation.energy_error().abs() < 1e-9, "{mu}: {}", simulation.energy_error());
        simulation.advance(0.4, &mut inputs).unwrap();
        assert!(simulation.energy_error().abs() < 1e-7, "{mu}: {}", simulation.energy_error());
    }
}
