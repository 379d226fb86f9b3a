//! Many interfaces at rest that start to slip together: balls, pins and guides of robots and random
//! mechanisms.

use crate::common::random::*;
use crate::common::*;
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, Inputs, InterfaceMode as Doing, Method, Settings,
    Simulation, View,
};
use stiction_core::friction::{Curve, InterfaceShape, JointFriction, Law};
use stiction_core::joint::{Carrier, JointType};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Mat3, Pose, Vec3};

fn at(value: f64) -> Target<f64> {
    Target { value, rate: 0.0, acceleration: 0.0 }
}

/// Creates a platform on six UPS legs with friction at all 24 interfaces.
fn hexapod(mu: f64, curve: Option<Curve>) -> (Mechanism, Vec<Coordinate>, Vec<Target<f64>>) {
    let mut builder = MechanismBuilder::new("hexapod")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("platform").mass(8.0).inertia(diagonal(0.1, 0.1, 0.2)));
    let rub = |place: usize, radius: Option<f64>| {
        let law = Law::coulomb_viscous(mu, 0.0);
        let law = Law { curve: curve.clone().unwrap_or(Curve::Constant), ..law };
        JointFriction { place, law, ..friction(mu, 0.0, radius) }
    };
    let mut names = Vec::new();
    for leg in 0..6 {
        let angle = |offset: f64| (60.0 * f64::from(leg / 2 * 2) + offset).to_radians();
        let side = if leg % 2 == 0 { -1.0 } else { 1.0 };
        let (foot, tip) = (angle(12.0 * side), angle(45.0 * side));
        let foot = v(0.5 * foot.cos(), 0.5 * foot.sin(), 0.0);
        let tip = v(0.25 * tip.cos(), 0.25 * tip.sin(), 0.0);
        let top = tip + v(0.0, 0.0, 0.6);
        let way = top - foot;
        let length = way.norm();
        let frame = along(Vec3::zero(), way);
        let place = |at: Vec3<f64>| Pose { rotation: frame.rotation, position: at };
        let (lower, upper) = (format!("lower{leg}"), format!("upper{leg}"));
        // Both axes of the universal joint, z of J and x of K, are perpendicular to the leg.
        let universal =
            Pose { rotation: frame.rotation * Mat3::about_axis(0, (1.0, 0.0)), position: foot };
        let in_lower = Pose { rotation: Mat3::about_axis(0, (1.0, 0.0)), position: Vec3::zero() };
        builder = builder
            .body(
                BodySpec::new(&lower)
                    .mass(1.0)
                    .com(v(0.0, 0.0, 0.15))
                    .inertia(diagonal(0.01, 0.01, 0.001)),
            )
            .body(
                BodySpec::new(&upper)
                    .mass(0.6)
                    .com(v(0.0, 0.0, -0.1))
                    .inertia(diagonal(0.005, 0.005, 0.0005)),
            )
            .joint(
                JointSpec::new(format!("U{leg}"), JointType::Universal, "ground", &lower)
                    .frames(universal, in_lower)
                    .friction(rub(0, Some(0.01)))
                    .friction(rub(1, Some(0.01))),
            )
            .joint(
                JointSpec::new(format!("P{leg}"), JointType::Prismatic, &lower, &upper)
                    .start([length])
                    .actuated()
                    .friction(rub(0, None)),
            )
            .joint(
                JointSpec::new(format!("S{leg}"), JointType::Spherical, &upper, "platform")
                    .frames(Pose::identity(), place(tip))
                    .friction(rub(0, Some(0.012))),
            );
        names.push((format!("P{leg}"), length));
    }
    let mechanism = builder.build().unwrap();
    let coordinates = names
        .iter()
        .map(|(name, _)| Coordinate::Joint { joint: mechanism.joint_id(name).unwrap(), dof: 0 })
        .collect();
    let lengths = names.iter().map(|(_, length)| at(*length)).collect();
    (mechanism, coordinates, lengths)
}

/// Verifies all friction laws of a mechanism at rest, from the result at one instant alone. A
/// sticking interface must have no acceleration and friction within its limit. An interface that
/// begins to slide must have friction at its limit, opposite to its acceleration. Returns the
/// numbers of sticking and of sliding interfaces.
fn laws_at_rest(model: &Forward, simulation: &Simulation<'_>, case: &str) -> [usize; 2] {
    let now = simulation.instant();
    let (mut sticks, mut slides) = (0, 0);
    for (interface, moment) in model.parameters().interfaces.iter().zip(&now.interfaces) {
        let joint = interface.joint;
        let spec = &model.mechanism().joints()[joint];
        let [from, to] = [spec.predecessor.0, spec.successor.0];
        // At rest, the relative acceleration has no velocity terms.
        let relative = now.bodies.acceleration[to] - now.bodies.acceleration[from];
        let (j, k) = (now.bodies.frame_j[joint], now.bodies.frame_k[joint]);
        let turns = relative.angular;
        let moves = j.rotation.transpose_mul(relative.linear + turns.cross(k.position));
        let in_j = j.rotation.transpose_mul(turns);
        let in_k = k.rotation.transpose_mul(turns);
        let arms = interface.arms(model.parameters().pitch[joint]);
        let begins = match interface.shape {
            InterfaceShape::Pin { axis, carrier: Carrier::Predecessor, .. } => {
                [in_j.component(axis), 0.0, 0.0]
            }
            InterfaceShape::Pin { axis, .. } => [in_k.component(axis), 0.0, 0.0],
            InterfaceShape::Guide { .. } => [moves.z, 0.0, 0.0],
            InterfaceShape::Thread => [in_j.z, 0.0, 0.0],
            InterfaceShape::Sleeve => [in_j.z, moves.z, 0.0],
            InterfaceShape::Ball => in_k.to_array(),
            InterfaceShape::Plate => [moves.x, moves.y, in_j.z],
            InterfaceShape::Shaft { .. } => unreachable!("no random mechanism has drive trains"),
        };
        let begins = [0, 1, 2].map(|k| arms[k] * begins[k]);
        let [size, has] =
            [begins, moment.friction].map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
        match moment.interface {
            Doing::Sticks => {
                sticks += 1;
                // Accelerations are of the order of 10 m/s^2. Friction contributions without any
                // margin may exceed their limits by 1e-5.
                assert!(size < 1e-9, "{case}: {moment:?} {begins:?}");
                assert!(has <= moment.limit * (1.0 + 2e-5), "{case}: {moment:?}");
            }
            Doing::Slides(_) => {
                slides += 1;
                let along: f64 = begins.iter().zip(moment.friction).map(|(a, f)| a * f).sum();
                assert!((has - moment.limit).abs() < 1e-9 * has, "{case}: {moment:?}");
                // Friction must be opposite to the onset of sliding, to 1e-6 rad.
                assert!(along > (1.0 - 1e-11) * size * has, "{case}: {moment:?} {begins:?}");
            }
            Doing::AtLimit(_) => assert!((has - moment.limit).abs() < 1e-9 * has, "{case}"),
            Doing::Smooth => {}
        }
    }
    [sticks, slides]
}

/// Effort levels from all interfaces sticking to all sliding: 36 friction components at 24
/// interfaces, most of which start to slip together.
#[test]
fn all_joints_of_a_hexapod_start_to_slip() {
    let (mechanism, coordinates, lengths) = hexapod(0.3, None);
    let model = Forward::new(mechanism.clone(), &[]);
    let home = (mechanism.body_id("platform").unwrap(), Pose::at(v(0.0, 0.0, 0.6)));
    let state = model.assemble(&[home], &coordinates, &lengths).unwrap();
    let mut counts = Vec::new();
    for step in 0..60 {
        let push = 22.0 + 0.05 * f64::from(step);
        let mut inputs = ConstantEfforts(vec![push, push, push + 0.5, push, push - 0.5, push]);
        let simulation = model
            .start(0.0, state.clone(), Settings::default(), &mut inputs)
            .unwrap_or_else(|e| panic!("{push}: {e}"));
        counts.push(laws_at_rest(&model, &simulation, &push.to_string()));
    }
    println!("{counts:?}");
    assert!(counts[0] == [24, 0] && counts[59] == [0, 24], "{counts:?}");
    let partly = counts.iter().filter(|[sticks, slides]| sticks * slides > 0).count();
    assert!(partly > 5, "{counts:?}");
}

/// Every random mechanism at rest with friction in all joints must have accelerations that satisfy
/// the friction laws.
#[test]
fn random_mechanisms_at_rest_satisfy_the_friction_laws() {
    for mu in [0.1, 0.3] {
        let (mut all, mut partly) = (0, 0);
        for class in CLASSES {
            for seed in 0..25 {
                let (_, case) = case(class, seed, mu);
                let model = Forward::new(case.mechanism.clone(), &[]);
                let still = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
                let targets: Vec<_> =
                    case.targets.iter().map(|t| Target { value: t.value, ..still }).collect();
                let Ok(state) = model.assemble(&[], &case.coordinates, &targets) else { continue };
                let mut inputs = ConstantEfforts(vec![]);
                let name = format!("{class:?} {seed} {mu}");
                let simulation = model
                    .start(0.0, state, Settings::default(), &mut inputs)
                    .unwrap_or_else(|e| panic!("{name}: {e}"));
                let [sticks, slides] = laws_at_rest(&model, &simulation, &name);
                all += 1;
                partly += usize::from(sticks * slides > 0);
            }
        }
        println!("{mu}: {all}, {partly} in part");
        assert!(all > 180 && partly > 20, "{all} {partly}");
    }
}
/// Applies oscillating forces to the legs.
struct Shaken(f64);

impl Inputs for Shaken {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        for (k, effort) in efforts.iter_mut().enumerate() {
            *effort = self.0 + 6.0 * (9.0 * view.time * (1.0 + 0.1 * k as f64)).sin();
        }
    }
}

#[test]
fn a_hexapod_under_oscillating_forces_continues() {
    let (mechanism, coordinates, lengths) = hexapod(0.2, None);
    let model = Forward::new(mechanism.clone(), &[]);
    let home = (mechanism.body_id("platform").unwrap(), Pose::at(v(0.0, 0.0, 0.6)));
    let state = model.assemble(&[home], &coordinates, &lengths).unwrap();
    let mut inputs = Shaken(22.0);
    let settings = Settings { relative: 1e-7, absolute: 1e-9, ..Settings::default() };
    let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
    simulation.advance(0.5, &mut inputs).unwrap();
    let methods: Vec<Method> = simulation
        .events()
        .iter()
        .filter_map(|event| match event.kind {
            EventKind::Method { method } => Some(method),
            _ => None,
        })
        .collect();
    println!("{methods:?}, {} evaluations", simulation.evaluations());
    // The simulation uses time steps while the last sticking interfaces reach their limits, then
    // proceeds from event to event again.
    assert_eq!(methods.first(), Some(&Method::TimeStepping));
    assert_eq!(methods.last(), Some(&Method::EventDriven));
    assert_eq!(simulation.method(), Method::EventDriven);
    assert!(simulation.events().len() > 20);
    // Both simulations have tolerances of 1e-7.
    assert!(simulation.energy_error().abs() < 1e-6 * simulation.energies().turnover);
}
