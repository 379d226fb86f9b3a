//! Rigid gearings of joints, against closed forms, equivalent mechanisms and the mechanism without
//! gearings in the same motion.

use crate::common::{files, job, model_of, tables};
use crate::drive_trains::relative_error;
use stiction_core::dynamics::{Forces, FrictionMode, InverseDynamics, InverseError, Settings};
use stiction_core::forward::{self, ConstantEfforts, Forward, Simulation};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::mobility::Mobility;
use stiction_core::topology::TreeRule;
use stiction_format::{ModelFile, Source, gallery, read};

/// Returns the coordinate of a joint with one degree of freedom.
fn coordinate(mechanism: &Mechanism, joint: &str) -> Coordinate {
    Coordinate::Joint { joint: mechanism.joint_id(joint).unwrap(), dof: 0 }
}

fn at(value: f64, rate: f64, acceleration: f64) -> Target<f64> {
    Target { value, rate, acceleration }
}

fn solved(
    mechanism: &Mechanism,
    joints: &[(&str, Target<f64>)],
    rule: TreeRule,
) -> InverseDynamics {
    let coordinates: Vec<_> = joints.iter().map(|(name, _)| coordinate(mechanism, name)).collect();
    let targets: Vec<_> = joints.iter().map(|(_, target)| *target).collect();
    let settings = Settings { friction: FrictionMode::Converged, ..Settings::default() };
    InverseDynamics::with_tree(mechanism.clone(), rule, &[], &coordinates, &targets, settings)
        .unwrap()
}

const RULES: [TreeRule; 4] =
    [TreeRule::Structure, TreeRule::Random(1), TreeRule::Random(2), TreeRule::Random(3)];

fn assert_same_reactions(found: &Forces, expected: &Forces, within: f64, what: &str) {
    for (k, ((f, m), (g, n))) in found.reactions.iter().zip(&expected.reactions).enumerate() {
        let error = (*f - *g).norm().max((*m - *n).norm());
        assert!(error < within, "{what}, joint {k}: {error:e}");
    }
    for (found, expected) in found.interfaces.iter().zip(&expected.interfaces) {
        assert!((found.friction - expected.friction).abs() < within, "{what}");
    }
}

/// Creates two links in a vertical plane with friction in both joints; `more` is appended to the
/// model.
fn arm(more: &str) -> ModelFile {
    let friction = "friction = { mu = 0.1, radius = \"8 mm\", viscous = \"1 N s/m\" }";
    let text = format!(
        "gravity = [0, 0, -9.81]\n\
         [bodies.upper]\nmass = 2\ncom = [0.2, 0, 0]\ninertia = [0.002, 0.03, 0.03]\n\
         [bodies.lower]\nmass = 1\ncom = [0.15, 0, 0.01]\ninertia = [0.001, 0.01, 0.01]\n\
         [joints.a]\ntype = \"R\"\nfrom = \"ground\"\nto = \"upper\"\naxis = \"y\"\nactuated = true\n{friction}\n\
         [joints.b]\ntype = \"R\"\nfrom = \"upper\"\nto = \"lower\"\nat = [0.4, 0, 0]\naxis = \"y\"\n{friction}\n\
         [loads.none]\n{more}"
    );
    model_of("arm", &text)
}

const GEARED: &str = "[gearings.belt]\njoints = { a = 5, b = 2 }\noffset = \"0.3 rad\"\n";

/// Returns the motion of both joints of the arm with the gearing [`GEARED`].
fn arm_motion() -> [(&'static str, Target<f64>); 2] {
    let a = at(0.4, 1.3, -2.0);
    [("a", a), ("b", at((0.3 - 5.0 * a.value) / 2.0, -2.5 * a.rate, -2.5 * a.acceleration))]
}

/// Tests that the gearing exerts the same effort on the second joint as an actuator of this joint
/// would. The actuator of the first joint carries the reaction.
#[test]
fn geared_arm() {
    let geared = arm(GEARED).mechanism;
    let free = arm("").mechanism.with_actuator(JointId(1), 0);
    let mut expected = solved(&free, &arm_motion(), TreeRule::Structure);
    let expected = expected.solve(&[]).unwrap().clone();
    let mut solver = solved(&geared, &arm_motion()[..1], TreeRule::Structure);
    let found = solver.solve(&[]).unwrap().clone();
    let lambda = expected.efforts[1] / 2.0;
    assert!((found.gearings[0] - lambda).abs() < 1e-12 * lambda.abs());
    let effort = expected.efforts[0] - 5.0 * lambda;
    assert!((found.efforts[0] - effort).abs() < 1e-12 * effort.abs());
    assert_same_reactions(&found, &expected, 1e-11, "arm");
    assert!(found.power.residual().abs() < 1e-13 * found.power.turnover, "{:?}", found.power);
    let b = solver.joint_motion(JointId(1), 0);
    let wanted = arm_motion()[1].1;
    assert!((b.value - wanted.value).abs() < 1e-14 && (b.rate - wanted.rate).abs() < 1e-14);
    // Friction of the second joint acts on the actuator through the gearing.
    let shares = solver.shares().clone();
    let sum: f64 = shares.of_actuator(0).sum();
    assert!((sum - (found.efforts[0] - found.efforts_frictionless[0])).abs() < 1e-11);
    assert!(shares.of(0, 1).abs() > 1e-3);
    let dense = solver.solve_dense(&[]).unwrap();
    assert!(
        (dense.efforts[0] - effort).abs() < 1e-10 && (dense.gearings[0] - lambda).abs() < 1e-10
    );
    assert_same_reactions(dense, &expected, 1e-9, "dense");
}

/// Tests the mobility of the arm and of a five-bar whose motors are geared.
#[test]
fn gearings_count_in_mobility() {
    let mut solver = solved(&arm(GEARED).mechanism, &arm_motion()[..1], TreeRule::Structure);
    solver.solve(&[]).unwrap();
    let mobility = Mobility::of(&solver);
    assert_eq!((mobility.gruebler, mobility.instantaneous), (1, 1));
    assert_eq!(mobility.finite.decided(), Some(1));
    assert_eq!(mobility.redundant_constraints, 0);
    let solver = solved(&five_bar(true).mechanism, &five_bar_motion()[..1], TreeRule::Structure);
    let mobility = Mobility::of(&solver);
    assert_eq!((mobility.gruebler, mobility.instantaneous), (-2, 1));
    assert_eq!(mobility.finite.decided(), Some(1));
    assert_eq!(mobility.redundant_constraints, 3);
}

/// Creates the five-bar of the gallery. If `geared` is true, only the left crank is driven.
fn five_bar(geared: bool) -> ModelFile {
    let text = gallery::get("five-bar").unwrap();
    let (before, right) = text.split_once("[joints.right_motor]").unwrap();
    let text = match geared {
        true => {
            format!("{before}[joints.right_motor]{}", right.replacen("actuated = true\n", "", 1))
        }
        false => text.to_owned(),
    };
    // The motions of the gallery model prescribe the tool, so they are removed.
    let (text, _) = text.split_once("[motions.circle]").unwrap();
    let gearing = match geared {
        true => {
            "\n[gearings.cranks]\njoints = { left_motor = 1, right_motor = 0.8 }\noffset = \"170 deg\"\n"
        }
        false => "",
    };
    model_of("five-bar", &format!("{text}{gearing}"))
}

fn five_bar_motion() -> [(&'static str, Target<f64>); 2] {
    let left = at(140f64.to_radians(), 1.1, 3.0);
    let right = (170f64.to_radians() - left.value) / 0.8;
    let right = at(right, -left.rate / 0.8, -left.acceleration / 0.8);
    [("left_motor", left), ("right_motor", right)]
}

/// Tests the results of the geared five-bar for every spanning tree, with the sparse and the dense
/// solver.
#[test]
fn geared_five_bar() {
    let mut expected = solved(&five_bar(false).mechanism, &five_bar_motion(), TreeRule::Structure);
    let expected = expected.solve(&[]).unwrap().clone();
    let lambda = expected.efforts[1] / 0.8;
    for rule in RULES {
        let geared = five_bar(true).mechanism;
        let mut solver = solved(&geared, &five_bar_motion()[..1], rule);
        let found = solver.solve(&[]).unwrap().clone();
        assert!(solver.model().is_ok(), "by the sparse balance");
        assert!((found.gearings[0] - lambda).abs() < 1e-11, "{rule:?}: {found:?}");
        assert!((found.efforts[0] - (expected.efforts[0] - lambda)).abs() < 1e-11, "{rule:?}");
        assert_same_reactions(&found, &expected, 1e-10, &format!("{rule:?}"));
        assert!(found.power.residual().abs() < 1e-12 * found.power.turnover);
        let sum: f64 = solver.shares().of_actuator(0).sum();
        let friction = found.efforts[0] - found.efforts_frictionless[0];
        assert!((sum - friction).abs() < 1e-10 && friction.abs() > 1e-3);
        assert_eq!(solver.statics().determined_gearings(), [true]);
        let dense = solver.solve_dense(&[]).unwrap();
        assert!((dense.gearings[0] - lambda).abs() < 1e-9 && dense.gearings.len() == 1);
        assert!((dense.efforts[0] - found.efforts[0]).abs() < 1e-9);
        assert_same_reactions(dense, &expected, 1e-8, "dense");
    }
}

/// Tests that the efforts of both motors of a geared five-bar have the least sum of squares.
#[test]
fn two_motors_on_geared_joints() {
    let text = five_bar(true).mechanism.with_actuator(JointId(1), 0);
    let mut one = solved(&five_bar(true).mechanism, &five_bar_motion()[..1], TreeRule::Structure);
    let one = one.solve(&[]).unwrap().clone();
    let mut solver = solved(&text, &five_bar_motion()[..1], TreeRule::Structure);
    let found = solver.solve(&[]).unwrap().clone();
    // The effort on the single degree of freedom is left - right / 0.8.
    let (left, right) = (found.efforts[0], found.efforts[1]);
    assert!((left - right / 0.8 - one.efforts[0]).abs() < 1e-9);
    // In the least-squares solution, the efforts are orthogonal to the coefficients (1, 0.8), along
    // which they can be redistributed.
    assert!((left + 0.8 * right).abs() < 1e-9, "{left} {right}");
    let statics = solver.statics();
    assert_eq!(statics.determined_gearings(), [false]);
    assert_eq!(statics.determined_drives(), [false, false]);
}

/// Tests that a gearing between rotation and translation of a cylindrical joint is equivalent to a
/// screw.
#[test]
fn a_geared_cylinder_is_a_screw() {
    let body = "gravity = [1, 2, -9.81]\n[bodies.nut]\nmass = 3\ncom = [0.1, 0.02, 0.05]\n\
                inertia = [0.02, 0.03, 0.04]\n[loads.none]\n";
    let joint = |kind: &str| {
        format!(
            "[joints.screw]\ntype = \"{kind}\"\nfrom = \"ground\"\nto = \"nut\"\nat = [0.3, 0, 0]\naxis = [1, 2, 2]\n"
        )
    };
    let screw =
        model_of("screw", &format!("{body}{}pitch = \"30 mm/rev\"\nactuated = true\n", joint("H")));
    let cylinder = model_of(
        "cylinder",
        &format!(
            "{body}{}actuated = [\"angle\"]\n[gearings.lead]\n\
             joints = {{ \"screw.angle\" = \"30 mm/rev\", \"screw.slide\" = -1 }}\n",
            joint("C")
        ),
    );
    let motion = [("screw", at(0.7, 3.0, -5.0))];
    let mut expected = solved(&screw.mechanism, &motion, TreeRule::Structure);
    let expected = expected.solve(&[]).unwrap().clone();
    let mut solver = solved(&cylinder.mechanism, &motion, TreeRule::Structure);
    let found = solver.solve(&[]).unwrap().clone();
    assert!((found.efforts[0] - expected.efforts[0]).abs() < 1e-12, "{found:?} {expected:?}");
    assert_same_reactions(&found, &expected, 1e-11, "screw");
    // The effort of the gearing equals the axial force of the flanks of the screw.
    let axis = solver.bodies().frame_j[0].rotation.columns[2];
    let force = found.reactions[0].0.dot(axis);
    assert!((found.gearings[0] + force).abs() < 1e-11, "{} {force}", found.gearings[0]);
    let mobility = Mobility::of(&solver);
    assert_eq!((mobility.gruebler, mobility.instantaneous), (1, 1));

    let mut accelerations = Vec::new();
    for model in [&screw, &cylinder] {
        let (simulation, _) = released(&model.mechanism, &motion, &[0.4], TreeRule::Structure);
        accelerations.push(simulation.0);
    }
    let [a, b] = &accelerations[..] else { unreachable!() };
    assert!((a.acceleration - b.acceleration).abs() < 1e-11, "{a:?} {b:?}");
    assert!((a.value - b.value).abs() < 1e-9 && (a.rate - b.rate).abs() < 1e-9, "{a:?} {b:?}");
}

/// Returns the motion of the first joint after 0.2 s under constant efforts, the relative energy
/// error, and the efforts of the gearings. Checks that the gearing equations are satisfied.
fn released(
    mechanism: &Mechanism,
    start: &[(&str, Target<f64>)],
    efforts: &[f64],
    rule: TreeRule,
) -> ((Target<f64>, f64), Vec<f64>) {
    let model = Forward::with_tree(mechanism.clone(), rule, &[]);
    let mut inputs = ConstantEfforts(efforts.to_vec());
    let mut simulation = begun(&model, start, &mut inputs);
    simulation.advance(0.2, &mut inputs).unwrap();
    let joint = mechanism.joint_id(start[0].0).unwrap();
    let instant = simulation.instant();
    assert!(model.closure_error(&instant.bodies, &instant.state) < 1e-11);
    let error = relative_error(&simulation);
    ((simulation.joint_motion(joint, 0), error), instant.gearings.clone())
}

fn begun<'a>(
    model: &'a Forward,
    start: &[(&str, Target<f64>)],
    inputs: &mut ConstantEfforts,
) -> Simulation<'a> {
    let coordinates: Vec<_> =
        start.iter().map(|(name, _)| coordinate(model.mechanism(), name)).collect();
    let targets: Vec<_> = start.iter().map(|(_, target)| *target).collect();
    let state = model.assemble(&[], &coordinates, &targets).unwrap();
    model.start(0.0, state, forward::Settings::default(), inputs).unwrap()
}

/// Tests that the efforts of inverse dynamics cause the motion in forward dynamics, with the same
/// efforts of the gearing and the same reactions, for every spanning tree, and that the energy
/// balance closes.
#[test]
fn forward_against_inverse() {
    let cases = [
        (arm(GEARED).mechanism, &arm_motion()[..1]),
        (five_bar(true).mechanism, &five_bar_motion()[..1]),
    ];
    for (mechanism, motion) in cases {
        let mut inverse = solved(&mechanism, motion, TreeRule::Structure);
        let expected = inverse.solve(&[]).unwrap().clone();
        let mechanism = mechanism.starting_at(inverse.bodies().joint_poses());
        for rule in RULES {
            let model = Forward::with_tree(mechanism.clone(), rule, &[]);
            let mut efforts = ConstantEfforts(expected.efforts.clone());
            let mut simulation = begun(&model, motion, &mut efforts);
            let joint = mechanism.joint_id(motion[0].0).unwrap();
            let found = simulation.joint_motion(joint, 0).acceleration;
            assert!((found - motion[0].1.acceleration).abs() < 1e-9, "{rule:?}: {found}");
            let instant = simulation.instant();
            assert!((instant.gearings[0] - expected.gearings[0]).abs() < 1e-9, "{rule:?}");
            for (k, ((f, m), (g, n))) in
                instant.reactions().iter().zip(&expected.reactions).enumerate()
            {
                assert!((*f - *g).norm() < 1e-8 && (*m - *n).norm() < 1e-8, "{rule:?} {k}");
            }
            simulation.advance(0.2, &mut efforts).unwrap();
            assert!(relative_error(&simulation) < 1e-8, "{rule:?} {}", relative_error(&simulation));
        }
    }
}

/// Tests two flywheels with a gearing a = n b: the second flywheel adds J / n^2 to the inertia of
/// the first one. Friction of the second flywheel holds the first one up to the friction torque
/// divided by n.
#[test]
fn geared_flywheels() {
    let n = 4.0;
    let wheels = |friction: &str| {
        format!(
            "gravity = [0, 0, 0]\n\
             [bodies.fast]\nmass = 1\ncom = [0, 0, 0]\ninertia = [0.1, 0.1, 0.02]\n\
             [bodies.slow]\nmass = 1\ncom = [0, 0, 0]\ninertia = [0.1, 0.1, 0.8]\n\
             [joints.a]\ntype = \"R\"\nfrom = \"ground\"\nto = \"fast\"\naxis = \"z\"\nactuated = true\n\
             [joints.b]\ntype = \"R\"\nfrom = \"ground\"\nto = \"slow\"\nat = [1, 0, 0]\naxis = \"z\"\n{friction}\n\
             [loads.none]\n[gearings.wheels]\njoints = {{ a = 1, b = -{n} }}\n"
        )
    };
    let model = model_of("wheels", &wheels(""));
    let inertia = 0.02 + 0.8 / (n * n);
    let start = [("a", at(0.0, 0.0, 0.0))];
    let ((motion, error), gearing) =
        released(&model.mechanism, &start, &[0.5], TreeRule::Structure);
    assert!((motion.acceleration - 0.5 / inertia).abs() < 1e-12, "{motion:?}");
    assert!((motion.value - 0.02 * 0.5 / inertia).abs() < 1e-12 && error < 1e-12);
    // J b'' = -n lambda.
    let lambda = -0.8 * (0.5 / inertia / n) / n;
    assert!((gearing[0] - lambda).abs() < 1e-12, "{gearing:?} {lambda}");

    // 2 N m of friction at the slow wheel correspond to 0.5 N m at the fast one.
    let dry = "friction = { mu = 0.2, radius = \"50 mm\", preload = 200 }";
    let model = model_of("wheels", &wheels(dry));
    let held = released(&model.mechanism, &start, &[0.5 * (1.0 - 1e-9)], TreeRule::Structure);
    assert_eq!(held.0.0.rate, 0.0);
    assert!((held.1[0] + 0.5).abs() < 1e-8, "{held:?}");
    let ((motion, error), _) = released(&model.mechanism, &start, &[0.7], TreeRule::Structure);
    assert!((motion.acceleration - 0.2 / inertia).abs() < 1e-10, "{motion:?}");
    assert!(error < 1e-10);
}

/// Tests a gripper: one motor with its own shaft moves two fingers that can move independently (a
/// differential).
#[test]
fn one_motor_for_two_fingers() {
    let (ratio, rotor, left, right) = (200.0, 3e-6, 0.4, 0.7);
    let finger = |name: &str, mass: f64| {
        format!(
            "[bodies.{name}]\nmass = {mass}\ncom = [0, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n\
             [joints.{name}]\ntype = \"P\"\nfrom = \"ground\"\nto = \"{name}\"\naxis = \"x\"\n"
        )
    };
    let text = format!(
        "gravity = [0, 0, -9.81]\n{}{}\
         [bodies.shaft]\nmass = 0.01\ncom = [0, 0, 0]\ninertia = [1e-6, 1e-6, 2e-6]\n\
         [joints.shaft]\ntype = \"R\"\nfrom = \"ground\"\nto = \"shaft\"\naxis = \"z\"\n\
         [actuators.motor]\njoint = \"shaft\"\nratio = 2\nrotor_inertia = {rotor}\n\
         motor_friction = {{ constant = 0.001 }}\n\
         [gearings.tendon]\njoints = {{ shaft = \"{} m/rad\", left = 1, right = 1 }}\n[loads.none]\n",
        finger("left", left),
        finger("right", right),
        -1.0 / ratio,
    );
    let model = model_of("gripper", &text);
    // The tendon force accelerates both fingers: left'' = force / left, right'' = force / right.
    let start =
        [("left", at(0.01, 0.0, 0.0)), ("right", at(0.02, 0.0, 0.0)), ("shaft", at(6.0, 0.0, 0.0))];
    let (drive, friction) = (0.05, 2.0 * 0.001);
    // shaft'' = ratio (left'' + right''), force = m a for both.
    let sum = 1.0 / left + 1.0 / right;
    let inertia = 2e-6 + 4.0 * rotor;
    let force = (drive - friction) * ratio / (1.0 + inertia * ratio * ratio * sum);
    let ((motion, error), gearing) =
        released(&model.mechanism, &start, &[drive], TreeRule::Structure);
    assert!((motion.acceleration - force / left).abs() < 1e-10, "{motion:?} {}", force / left);
    assert!((gearing[0] - force).abs() < 1e-10 && error < 1e-10, "{gearing:?} {force}");
    let away = [("left", at(0.01, 0.0, 1.0)), ("right", at(0.02, 0.0, 1.0))];
    let state = solved(&model.mechanism, &away, TreeRule::Structure);
    assert_eq!(Mobility::of(&state).instantaneous, 2);
    // The motor alone cannot produce arbitrary motions of both fingers.
    let mut inverse = state;
    let refused = inverse.solve(&[]).unwrap_err();
    assert!(matches!(refused, InverseError::CannotCarry { .. }), "{refused}");
}

/// Tests that the loss of a gear follows from the effort that the gear transmits from its motor,
/// not from the effort of a gearing on the same joint.
#[test]
fn gear_losses_beside_gearings() {
    let text = "gravity = [0, 0, 0]\n\
         [bodies.fast]\nmass = 1\ncom = [0, 0, 0]\ninertia = [0.1, 0.1, 0.02]\n\
         [bodies.slow]\nmass = 1\ncom = [0, 0, 0]\ninertia = [0.1, 0.1, 0.8]\n\
         [joints.a]\ntype = \"R\"\nfrom = \"ground\"\nto = \"fast\"\naxis = \"z\"\n\
         [joints.b]\ntype = \"R\"\nfrom = \"ground\"\nto = \"slow\"\nat = [1, 0, 0]\naxis = \"z\"\n\
         [actuators.motor]\njoint = \"a\"\nratio = 3\nrotor_inertia = 1e-3\nefficiency = 0.7\n\
         [loads.none]\n[gearings.wheels]\njoints = { a = 1, b = -4 }\n";
    let model = model_of("wheels", text);
    let start = [("a", at(0.0, 2.0, 0.0))];
    let ((motion, error), _) = released(&model.mechanism, &start, &[0.6], TreeRule::Structure);
    // n tau_m = n^2 J a'' + tau_o / eta, tau_o = (0.02 + 0.8 / 16) a''.
    let expected = 0.6 / (9.0 * 1e-3 + (0.02 + 0.05) / 0.7);
    assert!((motion.acceleration - expected).abs() < 1e-10, "{} {expected}", motion.acceleration);
    assert!(error < 1e-10, "{error}");
}

/// Tests that tables and summaries contain the effort of the gearing, also after the model was
/// written and read again.
#[test]
fn results_of_runs() {
    let model = arm(&format!(
        "{GEARED}[motions.m]\nduration = 1\na = \"0.5 rad*sin(2*pi*t/1 s)\"\n[default]\nmotion = \"m\"\nload = \"none\"\n"
    ));
    let run = job(&model, "m", "none", FrictionMode::Converged);
    let mut table = tables(&run);
    let mut worst = 0.0_f64;
    let mut efforts = Vec::new();
    run.run(
        |sample| {
            worst =
                worst.max((sample.forces.power.residual() / sample.forces.power.turnover).abs());
            efforts.push(sample.forces.gearings[0]);
            use stiction_run::Sink;
            table.add(sample)
        },
        |_, _, _| true,
    )
    .unwrap();
    assert!(worst < 1e-12, "{worst}");
    let files = files(&run, table);
    let reactions = crate::common::Csv::parse(&files["reactions.csv"]);
    assert_eq!(reactions.column("belt.effort [N m]"), efforts);
    assert!(reactions.column("belt.determined").iter().all(|flag| *flag == 1.0));
    let written = stiction_run::exchange::model_file(
        &model.mechanism,
        "",
        stiction_run::exchange::Instant::default(),
    );
    let again = model_of("again", &written.unwrap());
    assert_eq!(again.mechanism.gearings(), model.mechanism.gearings());
}

fn errors(parts: &[&str]) -> String {
    let text = parts.concat();
    read(&Source::new("machine.toml", text), &|_| Err("no files".into())).unwrap_err().to_string()
}

#[test]
fn what_gearings_refuse() {
    let base = "gravity = [0, 0, 0]\n[bodies.x]\nmass = 1\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n\
                [bodies.y]\nmass = 1\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n\
                [joints.a]\ntype = \"R\"\nfrom = \"ground\"\nto = \"x\"\naxis = \"z\"\n\
                [joints.b]\ntype = \"R\"\nfrom = \"x\"\nto = \"y\"\nat = [1, 0, 0]\naxis = \"z\"\n\
                [joints.c]\ntype = \"C\"\nfrom = \"y\"\nto = \"ground\"\nat = [1, 0, 0]\naxis = \"z\"\n[loads.none]\n";
    let cases = [
        ("joints = { a = 1, d = 2 }", "connects joint `d`, which does not exist"),
        ("joints = { a = 1 }", "connects fewer than two degrees of freedom"),
        ("joints = { a = 1, b = 0 }", "a coefficient is 0"),
        ("joints = { a = 1, c = 1 }", "has several degrees of freedom: name one of"),
        ("joints = { a = \"2 rad\", \"c.slide\" = 1 }", "expected a pitch"),
        ("joints = { a = 1, b = 2 }\noffset = \"2 m\"", "expected an angle"),
        ("offset = 2", "has no `joints`"),
        (
            "joints = { a = 1, b = 2, \"c.angle\" = 1 }",
            "every joint of a loop through `c` is in a gearing",
        ),
    ];
    for (text, expected) in cases {
        let message = errors(&[base, "[gearings.g]\n", text, "\n"]);
        assert!(message.contains(expected), "{text}: {message}");
    }
    let message = errors(&[base, "[gearings.g]\njoints = { a = 1, b = 1 }\nratio = 2\n"]);
    assert!(message.contains("has no key `ratio`"), "{message}");
}
