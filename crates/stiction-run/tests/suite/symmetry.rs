//! Friction under mirror images and time reversal, the effect of the friction of single interfaces
//! on reactions, and a pendulum whose journal is loaded by its own swing.

use crate::common::*;
use stiction_core::dynamics::FrictionMode;

const TWIN: &str = "zhang2018-regular";

/// Creates the regular variant of the printed robot with further motions and friction laws.
fn twin(change: impl Fn(String) -> String) -> stiction_format::ModelFile {
    let motion = |name: &str, x: &str, ry: &str, t: &str| {
        format!(
            "[motions.{name}]\nduration = \"1 s\"\nstep = \"0.1 s\"\nstart = \"0.03 s\"\n\
             platform.x = \"{x}(60 mm + 20 mm*sin(2*pi*{t}))\"\n\
             platform.z = \"500 mm + 30 mm*cos(2*pi*{t})\"\n\
             platform.ry = \"{ry}(90 deg - (65 deg + 5 deg*sin(2*pi*{t} + 0.7 rad)))\"\n"
        )
    };
    let text = stiction_format::gallery::get(TWIN).unwrap().to_owned()
        + "\n"
        + &motion("forth", "1*", "1*", "t")
        + &motion("mirrored", "-1*", "-1*", "t")
        // The last sample of one motion is the first of the other.
        + &motion("back", "1*", "1*", "(1.06 - t)")
        + &motion("mirrored_back", "-1*", "-1*", "(1.06 - t)");
    model_of(TWIN, &change(text))
}

fn drive(run: &Run, leg: usize, what: &str) -> Vec<f64> {
    run.inverse.column(&format!("leg{leg}.P.{what} [N]")).to_vec()
}

fn assert_near(what: &str, a: &[f64], b: &[f64]) {
    let largest = a.iter().fold(1.0f64, |max, x| max.max(x.abs()));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        // Actuator forces agree to some hundred rounding errors.
        assert!((a - b).abs() < 1e-12 * largest, "{what}: {a} {b}");
    }
}

/// Tests that a mirrored motion exchanges legs 2 and 3, because the robot is its own mirror image
/// in the plane y z.
#[test]
fn a_mirrored_motion_swaps_legs() {
    let model = twin(|text| text);
    for mode in MODES {
        let run = |motion: &str| Run::of(&job(&model, motion, "L0", mode)).unwrap();
        let (forth, mirrored) = (run("forth"), run("mirrored"));
        for (leg, other) in [(1, 1), (2, 3), (3, 2)] {
            let (a, b) = (drive(&forth, leg, "drive"), drive(&mirrored, other, "drive"));
            assert_near(&format!("{mode:?} leg{leg}"), &a, &b);
        }
    }
}

/// Tests that a motion that is mirrored and reversed in time requires the same frictionless forces
/// with the legs exchanged, and friction of opposite sign.
#[test]
fn a_mirrored_motion_backwards_swaps_legs_and_turns_friction_round() {
    let model = twin(|text| text);
    for motion in ["back", "mirrored_back"] {
        let mode = FrictionMode::OnePass;
        let forth = Run::of(&job(&model, "forth", "L0", mode)).unwrap();
        let back = Run::of(&job(&model, motion, "L0", mode)).unwrap();
        let swapped = if motion == "back" { [1, 2, 3] } else { [1, 3, 2] };
        for (leg, other) in [1, 2, 3].into_iter().zip(swapped) {
            let frictionless = drive(&forth, leg, "drive_frictionless");
            let mut same = drive(&back, other, "drive_frictionless");
            same.reverse();
            assert_near(&format!("{motion} leg{leg}"), &frictionless, &same);
            let friction = |run: &Run, leg: usize| -> Vec<f64> {
                let with = drive(run, leg, "drive");
                let without = drive(run, leg, "drive_frictionless");
                with.iter().zip(&without).map(|(a, b)| a - b).collect()
            };
            let mut turned = friction(&back, other);
            turned.reverse();
            let turned: Vec<f64> = turned.iter().map(|f| -f).collect();
            assert_near(&format!("{motion} leg{leg} friction"), &friction(&forth, leg), &turned);
        }
    }
}

/// Tests that the friction of a slide, which acts along the leg, changes only the force of the
/// actuator of this leg and no reaction.
#[test]
fn friction_of_slides_changes_no_reaction() {
    let slide = "friction = { mu = 0.12, viscous = \"0.02 N s/m\" }\n\n[legs.joints.S]";
    let with = |mu: &str| {
        let changed = format!("friction = {{ mu = {mu} }}\n\n[legs.joints.S]");
        let model = twin(|text| {
            assert!(text.contains(slide));
            text.replace(slide, &changed)
        });
        Run::of(&job(&model, "forth", "L1", FrictionMode::Converged)).unwrap()
    };
    let (none, some, much) = (with("0"), with("0.12"), with("0.5"));
    for run in [&some, &much] {
        for (name, column) in none.reactions.columns() {
            let is_slide = name.contains(".P.f");
            if name.starts_with("time") || name.ends_with("determined") || is_slide {
                continue;
            }
            assert_near(name, column, run.reactions.column(name));
        }
    }
    let changed = drive(&much, 1, "drive");
    let apart =
        drive(&none, 1, "drive").iter().zip(&changed).map(|(a, b)| (a - b).abs()).sum::<f64>();
    assert!(apart > 0.1, "the drives do change: {apart}");
}

/// Tests a point mass on a rod that swings freely against the friction of its journal, `mu r |R|`
/// with the full reaction. The closed form of the swing is known; along this swing the actuator
/// torque must be zero.
#[test]
fn a_pendulum_in_its_journal_swings_by_itself() {
    let (mu, r, g): (f64, f64, f64) = (0.3, 0.05, 9.81);
    let e = mu * r;
    let a = e / (1.0 - e * e).sqrt();
    let (big_a, big_b) =
        (2.0 * g * (1.0 - 2.0 * a * a) / (1.0 + 4.0 * a * a), -6.0 * a * g / (1.0 + 4.0 * a * a));
    let start = -80f64.to_radians();
    let c = -(big_a * start.cos() + big_b * start.sin()) * (2.0 * a * start).exp();
    let squared = |q: f64| big_a * q.cos() + big_b * q.sin() + c * (-2.0 * a * q).exp();
    // The reference states the speed at the bottom, and the position of rest.
    assert!((squared(0.0).sqrt() - 3.936_696_880_601_61).abs() < 1e-12);
    assert!(squared(75.843_919_085_01f64.to_radians()).abs() < 1e-11);
    for degrees in [-79, -60, -31, 0, 14, 45, 70, 75] {
        let q = f64::from(degrees).to_radians();
        let rate = squared(q).sqrt();
        let acceleration =
            0.5 * (big_b * q.cos() - big_a * q.sin() - 2.0 * a * c * (-2.0 * a * q).exp());
        let text = format!(
            r#"
            gravity = [0, "-9.81 m/s^2", 0]
            [bodies.bob]
            mass = 1
            com = [0, -1, 0]
            inertia = [0, 0, 0]
            [joints.pivot]
            type = "R"
            from = "ground"
            to = "bob"
            axis = "z"
            actuated = true
            friction = {{ mu = {mu:?}, radius = {r:?} }}
            [motions.swing]
            duration = "1 ms"
            step = "1 ms"
            pivot = "{q:?} rad + {rate:?} rad*t + {half:?} rad*t^2"
            [loads.none]
            "#,
            half = 0.5 * acceleration,
        );
        let model = model_of("pendulum", &text);
        let run = Run::of(&job(&model, "swing", "none", FrictionMode::Converged)).unwrap();
        let drive = run.inverse.column("pivot.drive [N m]")[0];
        // The tolerance is relative to about 20 N m.
        assert!(drive.abs() < 1e-12, "{degrees}: {drive}");
        // The radial load is the full reaction of the mass alone.
        let along = rate * rate + g * q.cos();
        let across = acceleration + g * q.sin();
        let load = run.friction.column("pivot.load [N]")[0];
        assert!((load - along.hypot(across)).abs() < 1e-12 * load, "{degrees}: {load}");
    }
}
