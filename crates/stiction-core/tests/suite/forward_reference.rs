//! Forward dynamics compared with the reference data.

use crate::common::*;
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, ForwardError, Known, Settings, Simulation,
};
use stiction_core::friction::{JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder, SpringSpec};
use stiction_core::spatial::{Pose, Vec3};

fn at(value: f64, rate: f64) -> Target<f64> {
    Target { value, rate, acceleration: 0.0 }
}

fn fine() -> Settings {
    Settings { relative: 1e-12, absolute: 1e-13, ..Settings::default() }
}

fn none() -> ConstantEfforts {
    ConstantEfforts(vec![])
}

/// Returns the coordinate of the first joint of a mechanism with one DOF.
fn first_joint(mechanism: &Mechanism) -> Coordinate {
    Coordinate::Joint { joint: mechanism.joint_id(&mechanism.joints()[0].name).unwrap(), dof: 0 }
}

/// Computes the world position of a point of a body, m.
fn point(simulation: &Simulation<'_>, model: &Forward, body: &str, local: Vec3<f64>) -> Vec3<f64> {
    let id = model.mechanism().body_id(body).unwrap();
    simulation.instant().bodies.pose[id.0].apply(local) + model.parameters().origin
}

fn pendulum() -> Mechanism {
    MechanismBuilder::new("pendulum")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("bob").mass(1.0).com(v(1.0, 0.0, 0.0)))
        .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob"))
        .build()
        .unwrap()
}

#[test]
fn r1_pendulum() {
    let model = Forward::new(pendulum(), &[]);
    let half = std::f64::consts::PI;
    let state = model.assemble(&[], &[first_joint(model.mechanism())], &[at(half, 0.0)]).unwrap();
    let mut simulation = model.start(0.0, state, fine(), &mut none()).unwrap();
    for (t, x, y) in [
        (1.0, 0.9862917511319, -0.1650108531255),
        (5.0, -0.9423054350438, -0.334754338414),
        (10.0, -0.2750874625761, -0.9614192050991),
    ] {
        simulation.advance(t, &mut none()).unwrap();
        let bob = point(&simulation, &model, "bob", v(1.0, 0.0, 0.0));
        let error = (bob - v(x, y, 0.0)).norm();
        println!("R1 t={t}: {error:.2e}, energy {:.2e}", simulation.energy_error());
        // The last digit of the reference is 1e-13; step errors accumulate over 10 s.
        assert!(error < 1e-10, "{t}: {error:e}");
    }
    println!("R1 evaluations {}", simulation.evaluations());
    assert!(simulation.energy_error().abs() < 1e-9);
}

/// Creates reference R2: N four-bar loops with parallel uprights. The mechanism is singular if all
/// bars are on one line.
fn n_four_bar(n: usize) -> Mechanism {
    let rod = || diagonal(0.0, 1.0 / 12.0, 1.0 / 12.0);
    let mut builder = MechanismBuilder::new("n-four-bar").gravity(v(0.0, -9.81, 0.0));
    for k in 0..=n {
        let vertical = format!("v{k}");
        builder = builder
            .body(BodySpec::new(&vertical).mass(1.0).com(v(0.5, 0.0, 0.0)).inertia(rod()))
            .joint(
                JointSpec::new(format!("A{k}"), JointType::Revolute, "ground", &vertical)
                    .frames(Pose::at(v(k as f64, 0.0, 0.0)), Pose::identity())
                    .start([std::f64::consts::FRAC_PI_2]),
            );
    }
    for k in 0..n {
        let coupler = format!("c{k}");
        let (left, right) = (format!("v{k}"), format!("v{}", k + 1));
        builder = builder
            .body(BodySpec::new(&coupler).mass(1.0).com(v(0.5, 0.0, 0.0)).inertia(rod()))
            .joint(
                JointSpec::new(format!("B{k}"), JointType::Revolute, &left, &coupler)
                    .frames(Pose::at(v(1.0, 0.0, 0.0)), Pose::identity())
                    .start([-std::f64::consts::FRAC_PI_2]),
            )
            .joint(
                JointSpec::new(format!("C{k}"), JointType::Revolute, &coupler, &right)
                    .frames(Pose::at(v(1.0, 0.0, 0.0)), Pose::at(v(1.0, 0.0, 0.0)))
                    .start([std::f64::consts::FRAC_PI_2]),
            );
    }
    builder.build().unwrap()
}

/// Times of the recorded passages of singular configurations, s.
fn singular_times(simulation: &Simulation<'_>) -> Vec<f64> {
    let events = simulation.events().iter();
    let singular = events.filter(|event| matches!(event.kind, EventKind::Singular { .. }));
    singular.map(|event| event.time).collect()
}

/// Time, s, in which the uprights of N four-bar loops fall from one angle to another, by Simpson's
/// rule, if they have the rate -1 rad/s at the angle `start`.
fn time_between(loops: usize, start: f64, (from, to): (f64, f64)) -> f64 {
    let (n, loops) = (4000, loops as f64);
    let pull = (0.5 * (loops + 1.0) + loops) / ((loops + 1.0) / 3.0 + loops) * 9.81;
    let part = |k: usize| {
        let angle = from + (to - from) * k as f64 / n as f64;
        let weight = if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
        weight / (1.0 + 2.0 * pull * (start.sin() - angle.sin())).sqrt()
    };
    (from - to) / (3.0 * n as f64) * (0..=n).map(part).sum::<f64>()
}

/// Long rows are decomposed sparsely. All their loops are singular at the same time, because the
/// closure equations along the line of the bars vanish.
#[test]
fn long_rows_of_four_bars_pass_singular_positions() {
    for count in [2, 20, 60] {
        let model = Forward::new(n_four_bar(count), &[]);
        let start = [at(0.3, -1.0)];
        let state = model.assemble(&[], &[first_joint(model.mechanism())], &start).unwrap();
        let mut simulation = model.start(0.0, state, fine(), &mut none()).unwrap();
        simulation.advance(0.5, &mut none()).unwrap();
        let told = singular_times(&simulation);
        let bars = count as f64;
        let expected = time_between(count, 0.3, (0.3, 0.0));
        assert_eq!(told.len(), 1, "{count}: {told:?}");
        // The tolerance of the steps is 1e-12. Close to the singular position, closure errors due to
        // round-off change the rates by their ratio to the squared index.
        assert!((told[0] - expected).abs() < 1e-7, "{count}: {told:?} {expected}");
        assert!(simulation.energy_error().abs() < 1e-8, "{count}: {}", simulation.energy_error());
        // All uprights remain parallel.
        let tip = |name: String, base: f64| {
            point(&simulation, &model, &name, v(1.0, 0.0, 0.0)) - v(base, 0.0, 0.0)
        };
        let apart = (tip("v0".into(), 0.0) - tip(format!("v{count}"), bars)).norm();
        assert!(apart < 1e-8, "{count}: {apart:e}");
    }
}

#[test]
fn r2_four_bars_pass_singular_positions() {
    let model = Forward::new(n_four_bar(2), &[]);
    let up = std::f64::consts::FRAC_PI_2;
    let state = model.assemble(&[], &[first_joint(model.mechanism())], &[at(up, -1.0)]).unwrap();
    let mut simulation = model.start(0.0, state, fine(), &mut none()).unwrap();
    let account = &simulation.instant().account;
    assert!((account.kinetic - 1.5).abs() < 1e-13);
    for (t, x, y) in [
        (1.0, -0.1950203019, -0.9807992057),
        (2.0, 0.0578157958, 0.9983272679),
        (5.0, -0.8113104610, -0.5846155454),
        (10.0, 0.3284581115, 0.9445185382),
    ] {
        simulation.advance(t, &mut none()).unwrap();
        let tip = point(&simulation, &model, "v0", v(1.0, 0.0, 0.0));
        let error = (tip - v(x, y, 0.0)).norm();
        println!("R2 t={t}: {error:.2e}, energy {:.2e}", simulation.energy_error());
        // The reference has ten decimals. The motion passes about 25 singular configurations. Each
        // one magnifies rounding by the inverse square of its distance from the nearest stage of a
        // step.
        assert!(error < if t < 9.0 { 1e-8 } else { 5e-8 }, "{t}: {error:e}");
    }
    // All bars are on one line if the uprights are at 0 or 180 degrees. Each passage must be
    // reported.
    let told = singular_times(&simulation);
    let between = |from: f64, to: f64| time_between(2, up, (from, to));
    let half = std::f64::consts::PI;
    let (first, below, above) = (between(up, 0.0), between(0.0, -half), between(half, 0.0));
    println!("R2 passes singular positions at {told:?}, first {first}");
    let mut expected = Vec::new();
    let mut time = first;
    while time < 10.0 {
        expected.push(time);
        time += if expected.len() % 2 == 1 { below } else { above };
    }
    assert_eq!(told.len(), expected.len(), "{told:?} {expected:?}");
    for (told, expected) in told.iter().zip(&expected) {
        // The minimum of a function that is zero there is resolved to about 1e-8.
        assert!((told - expected).abs() < 1e-6, "{told} {expected}");
    }
}

/// A simulation that starts at a singular configuration with the rates of one branch continues as
/// if it had arrived there by moving.
#[test]
fn r2_starts_in_a_singular_position() {
    let model = Forward::new(n_four_bar(2), &[]);
    // With 2 loops `I = 3`, `G = 7/2`.
    let pull: f64 = 3.5 / 3.0 * 9.81;
    let up = std::f64::consts::FRAC_PI_2;
    let first = first_joint(model.mechanism());
    let come = model.assemble(&[], &[first], &[at(up, -1.0)]).unwrap();
    let mut come = model.start(0.0, come, fine(), &mut none()).unwrap();
    come.advance(0.5, &mut none()).unwrap();
    let mut until = 0.5;
    while singular_times(&come).is_empty() {
        until += 0.1;
        come.advance(until, &mut none()).unwrap();
    }
    let passed = singular_times(&come)[0];
    let rate = -(1.0 + 2.0 * pull).sqrt();
    let known: Vec<Known> = model
        .mechanism()
        .joints()
        .iter()
        .map(|joint| {
            let turns = if joint.name.starts_with('C') { 1.0 } else { -1.0 };
            let (value, turns) =
                if joint.name.starts_with('A') { (0.0, 1.0) } else { (0.0, turns) };
            let id = model.mechanism().joint_id(&joint.name).unwrap();
            let coordinate = Coordinate::Joint { joint: id, dof: 0 };
            Known { coordinate, value: Some(value), rate: Some(turns * rate) }
        })
        .collect();
    let state = model.assemble_from(&[], &known).unwrap();
    let mut starts = model.start(0.0, state, fine(), &mut none()).unwrap();
    for time in [0.05, 0.2, 0.4] {
        starts.advance(time, &mut none()).unwrap();
        let target = passed + time;
        come.advance(target.max(come.instant().time), &mut none()).unwrap();
        let tip = |s: &Simulation<'_>| point(s, &model, "v0", v(1.0, 0.0, 0.0));
        // The energy is the same, so the closed form of the rate also determines the angle.
        let (a, b) = (tip(&starts), tip(&come));
        println!("{time}: {:.1e}, energy {:.1e}", (a - b).norm(), starts.energy_error());
        if come.instant().time == target {
            assert!((a - b).norm() < 1e-7, "{time}: {:e}", (a - b).norm());
        }
    }
    assert_eq!(singular_times(&starts).first(), Some(&0.0));
    // Rates that mix both branches permit no motion.
    let mixed: Vec<Known> = known
        .iter()
        .enumerate()
        .map(|(k, known)| {
            let rate = known.rate.map(|r| if k == 0 { -r } else { r });
            Known { rate, ..*known }
        })
        .collect();
    if let Ok(state) = model.assemble_from(&[], &mixed) {
        let error = model.start(0.0, state, fine(), &mut none()).map(|_| ()).unwrap_err();
        println!("{error}");
        assert!(matches!(error, ForwardError::Blocked { .. }), "{error}");
    }
}

/// Creates Andrews' squeezer without friction, with the lengths and masses of reference R3.
fn andrews() -> Mechanism {
    let start = [
        ("beta", -0.061_713_890_014_276_45),
        ("theta", 0.0),
        ("gamma", 0.455_279_819_163_070_4),
        ("phi", 0.222_668_390_165_885_88),
        ("delta", 0.487_364_979_543_842_55),
        ("Omega", -0.222_668_390_165_885_88),
        ("epsilon", 1.230_547_444_549_821_2),
    ];
    let bodies = [
        (0.04325, 2.194e-6, v(0.00092, 0.0, 0.0)),
        (0.00365, 4.410e-7, v(-0.0115, 0.0, 0.0)),
        (0.02373, 5.255e-6, v(0.01043, -0.01874, 0.0)),
        (0.00706, 5.667e-7, v(0.0, -(0.02 - 0.01421), 0.0)),
        (0.07050, 1.169e-5, v(0.02308, 0.00916, 0.0)),
        (0.00706, 5.667e-7, v(0.02 - 0.01421, 0.0, 0.0)),
        (0.05498, 1.912e-5, v(-0.00449, -0.01228, 0.0)),
    ];
    let mut builder = MechanismBuilder::new("andrews").gravity(Vec3::zero());
    for (k, (mass, inertia, com)) in bodies.into_iter().enumerate() {
        let body = BodySpec::new(format!("K{}", k + 1)).mass(mass).com(com);
        builder = builder.body(body.inertia(diagonal(0.0, 0.0, inertia)));
    }
    let a = v(-0.06934, -0.00227, 0.0);
    let joints = [
        ("beta", "ground", "K1", v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        ("theta", "K1", "K2", v(0.007, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        ("gamma", "ground", "K3", v(-0.03635, 0.03273, 0.0), v(0.0, 0.0, 0.0)),
        ("phi", "K5", "K4", v(0.04, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        ("delta", "ground", "K5", a, v(0.0, 0.0, 0.0)),
        ("Omega", "K7", "K6", v(0.0, -0.04, 0.0), v(0.0, 0.0, 0.0)),
        ("epsilon", "ground", "K7", a, v(0.0, 0.0, 0.0)),
        ("pin3", "K2", "K3", v(-0.028, 0.0, 0.0), v(0.0, -0.035, 0.0)),
        ("pin4", "K2", "K4", v(-0.028, 0.0, 0.0), v(0.0, -0.02, 0.0)),
        ("pin6", "K2", "K6", v(-0.028, 0.0, 0.0), v(0.02, 0.0, 0.0)),
    ];
    for (name, from, to, in_from, in_to) in joints {
        let mut joint = JointSpec::new(name, JointType::Revolute, from, to)
            .frames(Pose::at(in_from), Pose::at(in_to));
        if name == "beta" {
            joint = joint.actuated();
        }
        let from_pins = [("pin3", 0.517), ("pin4", 0.7717), ("pin6", 1.0696)];
        if let Some((_, angle)) = start.iter().chain(&from_pins).find(|(n, _)| *n == name) {
            joint = joint.start([*angle]);
        }
        builder = builder.joint(joint);
    }
    let spring = SpringSpec::new("spring", "ground", "K3")
        .points(v(0.014, 0.072, 0.0), v(0.035 - 0.015, -0.018, 0.0))
        .stiffness(4530.0, 0.07785);
    builder.spring(spring).build().unwrap()
}

#[test]
fn r3_andrews_squeezer_with_its_reactions() {
    let mechanism = andrews();
    let model = Forward::new(mechanism.clone(), &[]);
    let beta = Coordinate::Joint { joint: mechanism.joint_id("beta").unwrap(), dof: 0 };
    let state = model.assemble(&[], &[beta], &[at(-0.061_713_890_014_276_45, 0.0)]).unwrap();
    let mut inputs = ConstantEfforts(vec![0.033]);
    let finest = Settings { relative: 1e-13, absolute: 1e-14, ..Settings::default() };
    let mut simulation = model.start(0.0, state, finest, &mut inputs).unwrap();
    let joint = |name: &str| mechanism.joint_id(name).unwrap().0;
    let pins = |simulation: &Simulation<'_>| {
        let reactions = simulation.instant().reactions();
        ["pin3", "pin4", "pin6"].map(|name| reactions[joint(name)].0)
    };
    let now = simulation.instant();
    let spin = |body: usize| now.bodies.acceleration[body].angular.z;
    println!("{} {} {:?}", spin(1), spin(2) - spin(1), pins(&simulation));
    // The reference has 15 digits.
    assert!((spin(1) - 14222.4439199541).abs() < 1e-7);
    assert!((spin(2) - spin(1) + 10666.8329399656).abs() < 1e-7);
    let first = pins(&simulation)[0];
    assert!((first - v(98.5668703962411, -6.12268834425567, 0.0)).norm() < 1e-9, "{first:?}");
    simulation.advance(0.03, &mut inputs).unwrap();
    let now = simulation.instant();
    let expected = [
        ("beta", 15.81077119629904),
        ("theta", -15.75637105984298),
        ("gamma", 0.04082224013073101),
        ("phi", -0.5347301163226948),
        ("delta", 0.5244099658805304),
        ("Omega", 0.5347301163226948),
        ("epsilon", 1.048080741042263),
    ];
    for (name, angle) in expected {
        let index = joint(name);
        let relative = now.bodies.frame_j[index].inverse() * now.bodies.frame_k[index];
        let found = relative.rotation.at(1, 0).atan2(relative.rotation.at(0, 0));
        let apart = (found - angle).sin().atan2((found - angle).cos());
        println!("R3 {name} {apart:.1e}");
        // The published angles differ from the computed ones by 1.1e-9 rad. An independent program
        // (21 redundant coordinates, numpy and DOP853 with tolerance 1e-13) has the same difference
        // to within 1e-12, so it is the error of the published solution.
        assert!(apart.abs() < 3e-9, "{name} {apart:e}");
    }
    let expected = [
        v(199.175333373191, -29.75531228015052, 0.0),
        v(23.06654119098399, 31.45271365475927, 0.0),
        v(22.64249232082739, 11.61740700019673, 0.0),
    ];
    // Value computed by the independent program.
    assert!((pins(&simulation)[0].x - 199.1753481).abs() < 1e-7);
    for (found, expected) in pins(&simulation).into_iter().zip(expected) {
        println!("R3 reaction {:.1e}", (found - expected).norm());
        // The reactions differ by 1.5e-5 N for the same reason: the independent program agrees with
        // the computed ones to 1e-8 N.
        assert!((found - expected).norm() < 3e-5, "{found:?} {expected:?}");
    }
}

fn bricard() -> Mechanism {
    let points = [
        v(0.0, 0.0, 0.0),
        v(1.0, 0.0, 0.0),
        v(1.0, -1.0, 0.0),
        v(1.0, -1.0, 1.0),
        v(0.0, -1.0, 1.0),
        v(0.0, 0.0, 1.0),
    ];
    let axes = [1, 2, 0, 1, 2, 0].map(Vec3::unit);
    let mut builder = MechanismBuilder::new("bricard").gravity(v(0.0, -9.81, 0.0));
    for k in 0..5 {
        let along_rod = points[k + 1] - points[k];
        let inertia = |axis: Vec3<f64>| {
            let axial = along_rod.dot(axis).abs() > 0.5;
            if axial { 0.02 / 12.0 } else { 1.01 / 12.0 }
        };
        let inertia =
            diagonal(inertia(Vec3::unit(0)), inertia(Vec3::unit(1)), inertia(Vec3::unit(2)));
        builder = builder
            .body(BodySpec::new(format!("rod{k}")).mass(1.0).com(along_rod * 0.5).inertia(inertia));
    }
    let body = |k: usize| if k == 5 { "ground".to_owned() } else { format!("rod{k}") };
    for k in 0..6 {
        // Between the previous rod (the ground at P0) and the next one (the ground at P5).
        let before = if k == 0 { "ground".to_owned() } else { body(k - 1) };
        let in_before = if k == 0 { points[0] } else { points[k] - points[k - 1] };
        let in_after = if k == 5 { points[5] } else { Vec3::zero() };
        builder = builder.joint(
            JointSpec::new(format!("P{k}"), JointType::Revolute, before, body(k))
                .frames(along(in_before, axes[k]), along(in_after, axes[k])),
        );
    }
    builder.build().unwrap()
}

#[test]
fn r4_bricard_with_its_redundant_constraint() {
    let model = Forward::new(bricard(), &[]);
    let state = model.assemble(&[], &[first_joint(model.mechanism())], &[at(0.0, 0.0)]).unwrap();
    let mut simulation = model.start(0.0, state, fine(), &mut none()).unwrap();
    assert_eq!((simulation.instant().redundant, simulation.instant().mobility), (1, 1));
    for (t, expected) in [
        (1.0, v(0.51050146, -1.6491676, 0.14012311)),
        (2.0, v(-0.96934034, -1.22124689, 0.75427801)),
        (5.0, v(1.0, -1.00006726, 0.99993274)),
    ] {
        simulation.advance(t, &mut none()).unwrap();
        let p3 = point(&simulation, &model, "rod2", v(0.0, 0.0, 1.0));
        let error = (p3 - expected).norm();
        println!("R4 t={t}: {error:.2e}, energy {:.2e}", simulation.energy_error());
        // The reference has seven or eight decimals.
        assert!(error < 1e-7, "{t}: {error:e}");
    }
    assert!(simulation.energy_error().abs() < 1e-9);
}

#[test]
fn case_a_of_the_3rps() {
    let rub = [
        friction(0.0, 0.4 / 0.0125_f64.powi(2), Some(0.0125)),
        friction(0.0, 30.0, None),
        friction(0.0, 0.0, Some(0.025)),
    ];
    let worst = follow_3rps("3rps_symmetric_forward_A.csv", rub, [56.0, 52.0, 55.0], 0.0);
    // The reference is consistent to 5e-11 in states.
    assert!(worst.state < 1e-9, "{worst:?}");
    assert!(worst.reaction < 1e-8, "{worst:?}");
    assert!(worst.energy < 1e-9, "{worst:?}");
}

#[test]
fn load_dependent_friction_in_all_joints_of_the_3rps() {
    let law = |b: f64, radius: f64| Law {
        regularisation: Some(0.005),
        ..Law::coulomb_viscous(0.12, b / radius.powi(2))
    };
    let with = |b: f64, radius: Option<f64>| JointFriction {
        radius,
        ..JointFriction::guide(law(b, radius.unwrap_or(1.0)))
    };
    let rub = [with(0.4, Some(0.0125)), with(30.0, None), with(0.1, Some(0.025))];
    let worst =
        follow_3rps("3rps_symmetric_forward_loadfriction.csv", rub, [58.0, 52.0, 55.0], 0.0);
    // Two tolerances of the reference differ by 1.6e-8.
    assert!(worst.state < 1e-7, "{worst:?}");
    assert!(worst.energy < 1e-9, "{worst:?}");
}

#[derive(Debug, Default)]
struct Worst {
    state: f64,
    reaction: f64,
    energy: f64,
}

fn follow_3rps(file: &str, rub: [JointFriction; 3], efforts: [f64; 3], _: f64) -> Worst {
    let robot = symmetric_3rps(Some(rub));
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let start = [at(0.55, 0.0), at(0.0, 0.0), at(0.0, 0.0)];
    let state = model.assemble(&robot.initial_poses, &robot.coordinates, &start).unwrap();
    let mut inputs = ConstantEfforts(efforts.to_vec());
    let mut simulation = model.start(0.0, state, fine(), &mut inputs).unwrap();
    let platform = robot.mechanism.body_id("platform").unwrap().0;
    let origin = model.parameters().origin;
    let mut worst = Worst::default();
    for row in table(file) {
        let get = |name: &str| number(&row, name);
        simulation.advance(get("t"), &mut inputs).unwrap();
        let now = simulation.instant();
        let pose = now.bodies.pose[platform];
        let position = pose.position + origin;
        let has = |name: &str| row.contains_key(name);
        let mut state = |found: f64, name: &str| {
            if has(name) {
                worst.state = worst.state.max((found - get(name)).abs());
            }
        };
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            state(position.component(axis), name);
            let velocity = now.bodies.twist[platform].velocity_at(pose.position);
            state(velocity.component(axis), &format!("v{name}"));
            state(now.bodies.twist[platform].angular.component(axis), &format!("om{name}"));
            for column in 0..3 {
                let entry = pose.rotation.at(axis, column);
                state(entry, &format!("R{}{}", axis + 1, column + 1));
            }
        }
        for leg in 1..=3 {
            for (joint, value, rate) in [("R", "phi", "phid"), ("P", "d", "dd")] {
                let index = robot.mechanism.joint_id(&format!("leg{leg}.{joint}")).unwrap();
                let rates = now.bodies.joint_rates(model.topology(), index.0);
                state(rates[0], &format!("{rate}{leg}"));
                let relative = now.bodies.frame_j[index.0].inverse() * now.bodies.frame_k[index.0];
                if joint == "P" {
                    state(relative.position.norm(), &format!("{value}{leg}"));
                }
            }
        }
        let reactions = now.reactions();
        for leg in 1..=3 {
            let joint = robot.mechanism.joint_id(&format!("leg{leg}.S")).unwrap().0;
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                let found = reactions[joint].0.component(axis);
                worst.reaction =
                    worst.reaction.max((found - get(&format!("FS{leg}_{name}"))).abs());
            }
        }
        worst.energy = worst.energy.max(simulation.energy_error().abs());
    }
    println!("{file}: {worst:?}, {} evaluations", simulation.evaluations());
    worst
}
