//! Special motions: whole turns, local DOFs, passages through singular positions.

use crate::common::*;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{LoadCase, gallery};
use stiction_run::Job;

/// Returns the model of a body on three slides and three revolute joints, which can reach every
/// pose.
fn six_axes(coordinates: &str) -> String {
    let slide = |name: &str, from: &str, to: &str, kind: &str, axis: &str| {
        format!(
            "[joints.{name}]\ntype = \"{kind}\"\nfrom = \"{from}\"\nto = \"{to}\"\naxis = \"{axis}\"\n\
             actuated = true\n"
        )
    };
    let mut text = String::from("gravity = [0, 0, \"-9.81 m/s^2\"]\n");
    for body in ["a", "b", "c", "d", "e", "hand"] {
        text += &format!(
            "[bodies.{body}]\nmass = 1.0\ncom = [0.1, 0.05, -0.02]\ninertia = [0.01, 0.02, 0.025]\n"
        );
    }
    let chain = [
        ("x", "ground", "a", "P", "x"),
        ("y", "a", "b", "P", "y"),
        ("z", "b", "c", "P", "z"),
        ("A", "c", "d", "R", "x"),
        ("B", "d", "e", "R", "y"),
        ("C", "e", "hand", "R", "z"),
    ];
    for (name, from, to, kind, axis) in chain {
        text += &slide(name, from, to, kind, axis);
    }
    text + "[motions.m]\nduration = \"1 s\"\nhand.x = 0\nhand.y = 0\nhand.z = 0\n"
        + coordinates
        + "\n[loads.none]\n[default]\nmotion = \"m\"\nload = \"none\"\n"
}

fn drives(text: &str) -> Vec<Vec<f64>> {
    let model = model_of("six", text);
    let run = Run::of(&default_job(&model, FrictionMode::Off)).unwrap();
    assert!(run.closure < 1e-12);
    let columns = run.inverse.columns().filter(|(name, _)| name.contains(".drive "));
    columns.map(|(_, values)| values.clone()).collect()
}

/// Tests rotation vectors beyond half a turn and beyond whole turns, against the same motion in
/// angles.
#[test]
fn rotation_vectors_exceed_whole_turns() {
    let pairs = [
        ("rvx = 0\nrvy = 0\nrvz = \"20 rad/s*t\"", "rx = 0\nry = 0\nrz = \"20 rad/s*t\""),
        ("rvx = \"-9 rad/s*t\"\nrvy = 0\nrvz = 0", "rx = \"-9 rad/s*t\"\nry = 0\nrz = 0"),
    ];
    let named = |text: &str| text.lines().map(|line| format!("hand.{line}\n")).collect::<String>();
    for (vector, angles) in pairs {
        let (vector, angles) =
            (drives(&six_axes(&named(vector))), drives(&six_axes(&named(angles))));
        assert_eq!(vector.len(), 6);
        for (a, b) in vector.iter().flatten().zip(angles.iter().flatten()) {
            assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }
    // About an oblique axis through more than a turn, with a superimposed oscillation.
    drives(&six_axes(&named(
        "rvx = \"pi*1 rad*sin(2*pi*t)\"\nrvy = 0.3\nrvz = \"0.1 rad + 1 rad*t\"",
    )));
}

/// Returns the model of a crank that drives a lever through a rod between two balls.
fn rssr(rod: &str, friction: &str) -> String {
    format!(
        r#"
        gravity = [0, 0, "-9.81 m/s^2"]
        [bodies.crank]
        mass = 1.0
        com = [0.05, 0, 0]
        inertia = [1e-3, 1e-3, 1e-3]
        [bodies.rod]
        {rod}
        [bodies.lever]
        mass = 2.0
        com = [0.1, 0, 0]
        inertia = [1e-2, 1e-2, 1e-2]
        home = {{ position = [0.4, 0.1, 0], rotation = {{ axis = "x", angle = "90 deg" }} }}
        [joints]
        A = {{ type = "R", from = "ground", to = "crank", axis = "z", actuated = true {friction} }}
        B = {{ type = "S", from = "crank", to = "rod", at = [0.1, 0, 0] {friction} }}
        C = {{ type = "S", from = "rod", to = "lever", at = [0.35, 0, 0], to_at = [0.2, 0, 0], start = {{ axis = "y", angle = "-30 deg" }} {friction} }}
        D = {{ type = "R", from = "ground", to = "lever", at = [0.4, 0.1, 0], axis = "y", start = "-120 deg" {friction} }}
        [motions.m]
        duration = "1 s"
        A = "30 deg*sin(2*pi*t)"
        [loads.none]
        [default]
        motion = "m"
        load = "none"
        "#
    )
}

/// Tests that results for a massless rod are the limit of those for a light rod, also with friction
/// in its balls.
#[test]
fn a_massless_rod_is_a_light_one() {
    let light = "mass = 1e-9\ncom = [0, 0, 0]\ninertia = [1e-11, 1e-11, 1e-11]";
    for friction in ["", ", friction = { mu = 0.2, radius = \"10 mm\" }"] {
        let run = |rod: &str| {
            let model = model_of("rssr", &rssr(rod, friction));
            let run = Run::of(&default_job(&model, FrictionMode::Converged)).unwrap();
            assert!(run.power_residual < 1e-10, "{:e}", run.power_residual);
            assert_eq!(run.verdict.idle_spins, ["rod"]);
            run.inverse.column("A.drive [N m]").to_vec()
        };
        for (massless, light) in run("").iter().zip(run(light)) {
            assert!((massless - light).abs() < 1e-6, "{massless} {light}");
        }
    }
}

/// Tests a slider that drives its crank through both dead centres, at which it cannot transmit
/// torque.
#[test]
fn passed_singular_positions_are_reported() {
    let text = gallery::get("slider-crank").unwrap();
    let text = text.replacen("actuated = true\n", "", 1);
    let text =
        text.replacen("start = \"crank + rod\"", "start = \"crank + rod\"\nactuated = true", 1);
    let text = text.replacen("A = \"10 rad/s*t\"", "A = \"10 rad/s*t + 0.5 deg\"", 1);
    let model = model_of("slider", &text);
    let run = Run::of(&default_job(&model, FrictionMode::Off)).unwrap();
    let passed = &run.verdict.passed_singularities;
    let near = |(from, to): &(f64, f64), turn: f64| {
        let t = (turn * std::f64::consts::PI - 0.5_f64.to_radians()) / 10.0;
        *from <= t && t <= *to
    };
    assert_eq!(passed.len(), 2, "{passed:?}");
    assert!(near(&passed[0], 1.0) && near(&passed[1], 2.0), "{passed:?}");
}

/// Tests a parallelogram that rotates steadily in the horizontal plane. It requires forces but no
/// power, and can be computed at any speed.
#[test]
fn steady_rotation_is_not_noise() {
    for speed in [1.0, 50.0, 1e3, 1e4] {
        let text = format!(
            r#"
gravity=[0,0,"-9.81 m/s^2"]
[bodies.crank]
mass="1 kg"
com=["50 mm",0,0]
inertia=["1e-3 kg m^2","1e-3 kg m^2","1e-3 kg m^2"]
[bodies.rod]
mass="1 kg"
com=["150 mm",0,0]
inertia=["1e-3 kg m^2","1e-3 kg m^2","1e-3 kg m^2"]
[bodies.crank2]
mass="1 kg"
com=["50 mm",0,0]
inertia=["1e-3 kg m^2","1e-3 kg m^2","1e-3 kg m^2"]
[joints]
A={{type="R",from="ground",to="crank",axis="z",actuated=true}}
B={{type="R",from="crank",to="rod",at=["100 mm",0,0],axis="z"}}
D={{type="R",from="ground",to="crank2",at=["300 mm",0,0],axis="z"}}
C={{type="R",from="crank2",to="rod",at=["100 mm",0,0],to_at=["300 mm",0,0],axis="z"}}
[motions.run]
duration="20 ms"
step="0.1 ms"
A="1 rad + {speed} rad/s*t"
"#
        );
        let model = model_of("parallelogram", &text);
        let (motion, load) = (("m", &model.motions[0].1), LoadCase::default());
        let (friction, step) = (FrictionMode::Off, Some(0.1 / speed));
        let job = Job { friction, step, ..Job::new(&model, motion, ("none", &load)) };
        let run = Run::of(&job).unwrap();
        assert!(run.power_residual < 1e-10, "{speed}: {:e}", run.power_residual);
    }
}

/// Tests that the solver follows motions with kinks for any samples: on the kink, on both sides of
/// it, or far from it. The derivatives at the kink are the right-hand derivatives.
#[test]
fn kinks_are_followed() {
    let slider = gallery::get("slider-crank").unwrap();
    for step in [0.05, 0.04, 0.0417, 0.031, 0.01] {
        for (kinked, rate) in [
            ("hand.x = \"0.1 m + 1 m*abs(t - 0.15 s)/1 s\"", [-1.0, 1.0]),
            ("hand.x = \"max(0.2 m - t*1 m/1 s, 0.05 m)\"", [-1.0, 0.0]),
        ] {
            let text = six_axes(&format!("hand.rx = 0\nhand.ry = 0\nhand.rz = 0\n{kinked}\n"))
                .replacen("hand.x = 0\n", "", 1)
                .replacen("duration = \"1 s\"", "duration = \"300 ms\"", 1);
            let model = model_of("kink", &text);
            let job = Job { step: Some(step), ..default_job(&model, FrictionMode::Off) };
            let mut speeds = Vec::new();
            let look = |sample: &stiction_run::inverse::Sample| {
                let hand = sample.bodies.twist.last().expect("bodies");
                speeds.push((sample.time, hand.linear.component(0)));
                Ok(())
            };
            job.run(look, |_, _, _| true).unwrap_or_else(|error| panic!("{step}: {error}"));
            for (time, speed) in speeds {
                // At the kink, rounding determines on which side the sample lies.
                let expected = if time < 0.15 { rate[0] } else { rate[1] };
                let is_there = (time - 0.15).abs() < 1e-9;
                assert!(
                    is_there || (speed - expected).abs() < 1e-9,
                    "{step} {kinked}: {time} {speed}"
                );
            }
        }
        // The solver also follows motions with kinks in closed loops.
        let text = slider.replacen("A = \"10 rad/s*t\"", "A = \"1 rad*abs(sin(10*t))\"", 1);
        let model = model_of("kink", &text);
        let job = Job { step: Some(step), ..default_job(&model, FrictionMode::Off) };
        let run = Run::of(&job).unwrap();
        assert!(run.closure < 1e-12);
    }
}

/// Tests angles of orders such as zxz, which are undefined for the identity, the initial
/// orientation. The assembly nevertheless finds any orientation, and the result is the prescribed
/// one.
#[test]
fn all_orders_of_angles_assemble_without_a_guess() {
    for order in ["xyx", "yzy", "zxz", "xzx", "zyz", "yxy", "xyz", "zyx"] {
        let second =
            if order.starts_with(&order[2..]) { [0.3, 1.5, 2.8] } else { [-1.2, 0.1, 1.3] };
        for (k, second) in second.into_iter().enumerate() {
            let (first, third) = ([0.4, -1.9, 3.0][k], [-2.5, 0.2, 1.1][k]);
            let angles = |body: &str| {
                format!(
                    "{body}.order = \"{order}\"\n{body}.r1 = {first}\n{body}.r2 = \"{second} + 0.1*t\"\n\
                     {body}.r3 = {third}\n"
                )
            };
            let run = drives(&six_axes(&angles("hand")));
            assert!(run.iter().flatten().all(|x| x.is_finite()), "{order}");
        }
    }
}

/// Tests a slider that is pulled farther than the linkage reaches. It is reported as out of reach,
/// not as singular, although the last reachable position is always singular, regardless of the step
/// size. Starting at a dead centre does not imply that no other position is reachable.
#[test]
fn reachable_positions_are_reported() {
    let text = gallery::get("slider-crank").unwrap();
    let text = text.replacen("A = \"10 rad/s*t\"", "slider.x = \"379.7 mm + 0.21 m/s*t\"", 1);
    let model = model_of("reach", &text);
    for step in [0.15, 0.03, 0.01, 0.003] {
        let job = Job { step: Some(step), ..default_job(&model, FrictionMode::Off) };
        let error = Run::of(&job).map(|_| ()).unwrap_err().to_string();
        assert!(
            error.contains("out of reach") || error.contains("do not close"),
            "{step}: {error}"
        );
        assert!(!error.contains("t = 0 s"), "{step}: {error}");
    }
}

/// Tests sixteen parallelograms in a row, followed in coarse samples. An order of elimination
/// chosen at one position loses digits at the others. The torque is that of one pendulum.
#[test]
fn a_long_linkage_is_followed_in_coarse_steps() {
    let count = 16;
    let mut text = String::from("gravity = [0, 0, -9.81]\n");
    let body = |name: String, com: &str, inertia: f64| {
        format!(
            "[bodies.{name}]\nmass = 1\ncom = {com}\ninertia = [{inertia:e}, {inertia:e}, {inertia:e}]\n"
        )
    };
    for k in 0..=count {
        text += &body(format!("c{k}"), "[0, 0, 0.1]", 1e-3);
        text += &format!(
            "[joints.g{k}]\ntype = \"R\"\nfrom = \"ground\"\nto = \"c{k}\"\nat = [{k}, 0, 0]\naxis = \"y\"\n{}",
            if k == 0 { "actuated = true\n" } else { "" }
        );
    }
    for k in 0..count {
        text += &body(format!("k{k}"), "[0.5, 0, 0]", 1e-2);
        text += &format!(
            "[joints.p{k}]\ntype = \"R\"\nfrom = \"c{k}\"\nto = \"k{k}\"\nat = [0, 0, 0.2]\naxis = \"y\"\n\
             [joints.q{k}]\ntype = \"R\"\nfrom = \"k{k}\"\nto = \"c{}\"\nat = [1, 0, 0]\n\
             to_at = [0, 0, 0.2]\naxis = \"y\"\n",
            k + 1
        );
    }
    text += "[motions.m]\ng0 = \"0.3*sin(2*pi*t)\"\n[loads.none]\n[default]\nload = \"none\"\n";
    let model = model_of("parallelograms", &text);
    let (motion, load) = (("m", &model.motions[0].1), LoadCase::default());
    let cranks = f64::from(count) + 1.0;
    let inertia = cranks * (1e-3 + 0.01) + f64::from(count) * 0.04;
    let lever = cranks * 0.1 + f64::from(count) * 0.2;
    for step in [0.25, 0.2, 0.125, 0.1, 0.05] {
        let job = Job {
            friction: FrictionMode::Off,
            step: Some(step),
            ..Job::new(&model, motion, ("none", &load))
        };
        let run = Run::of(&job).unwrap_or_else(|error| panic!("{step}: {error}"));
        let times = run.inverse.column("time [s]");
        for (t, drive) in times.iter().zip(run.inverse.column("g0.drive [N m]")) {
            let turns = std::f64::consts::TAU;
            let (q, a) = (0.3 * (turns * t).sin(), -0.3 * turns * turns * (turns * t).sin());
            let expected = inertia * a - 9.81 * lever * q.sin();
            assert!((drive - expected).abs() < 1e-8, "{step}, {t}: {drive} {expected}");
        }
    }
}
