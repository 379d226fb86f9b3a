//! Friction contributions to each actuator force, and efficiencies: sums along all motions of the
//! gallery, and closed forms.

use crate::common::collar::push_beside;
use crate::common::*;
use serde_json::Value;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{LoadCase, ModelFile};
use stiction_run::inverse::{Backward, Summary, write_summary};
use stiction_run::{Job, Sink};

/// Tables of a run, and the summary of the run as JSON and as text.
struct Told {
    shares: Csv,
    inverse: Csv,
    friction: Csv,
    json: Value,
    text: String,
    /// Back-driving verdict of each actuator, sample by sample.
    backward: Vec<Vec<Backward>>,
}

fn tell(job: &Job<'_>) -> Told {
    let mut table = tables(job);
    let mut summary = Summary::new(job);
    let mut backward = Vec::new();
    let receive = |sample: &stiction_run::inverse::Sample| {
        backward.push(sample.backward.to_vec());
        (&mut summary, &mut table).add(sample)
    };
    let verdict = job.run(receive, |_, _, _| true).unwrap();
    let mut text = String::new();
    write_summary(&mut text, job, &summary, &verdict).unwrap();
    let run = Run::of(job).unwrap();
    Told {
        shares: files(job, table).get("contributions.csv").map_or_else(
            // Without friction, a run has no table of contributions.
            || Csv::parse(b"time [s]\n"),
            |file| Csv::parse(file),
        ),
        inverse: run.inverse,
        friction: run.friction,
        json: summary.json(job, &verdict),
        text,
        backward,
    }
}

/// Returns the columns `J.from.C [unit]` of actuator J.
fn from<'a>(told: &'a Told, drive: &str) -> Vec<(&'a str, &'a [f64])> {
    let prefix = format!("{drive}.from.");
    let columns = told.shares.columns().filter_map(|(name, column)| {
        let interface = name.strip_prefix(&prefix)?.split(" [").next()?;
        Some((interface, column.as_slice()))
    });
    columns.collect()
}

/// Tests the sums of contributions at every sample of every motion under every load.
#[test]
fn contributions_add_up_to_the_effect_of_friction() {
    let mut rows = 0;
    for name in regular() {
        let model = model(name);
        let friction = [FrictionMode::OnePass, FrictionMode::Converged];
        for ((motion, load), friction) in cases(&model).flat_map(|c| friction.map(|f| (c, f))) {
            let job = Job { step: coarse(&model, motion), ..job(&model, motion, load, friction) };
            if !job.has_shares() {
                continue;
            }
            let told = tell(&job);
            for (column, with) in told.inverse.columns() {
                let Some((drive, unit)) = column.split_once(".drive [") else { continue };
                let without = told.inverse.column(&format!("{drive}.drive_frictionless [{unit}"));
                let shares = from(&told, drive);
                // The error is relative to the sum of magnitudes; for an actuator with zero force,
                // it is relative to the largest force of the actuator.
                let most = with.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
                for (row, (with, without)) in with.iter().zip(without).enumerate() {
                    let sum: f64 = shares.iter().map(|(_, share)| share[row]).sum();
                    let size: f64 = shares.iter().map(|(_, share)| share[row].abs()).sum();
                    let miss = (with - without - sum).abs();
                    assert!(miss <= 1e-12 * (size + most), "{name} {motion} {drive}: {miss:e}");
                    rows += 1;
                }
            }
            // Interfaces at rest contribute nothing.
            for (interface, share) in told.shares.columns().filter_map(|(name, column)| {
                Some((name.split_once(".from.")?.1.split(" [").next()?, column))
            }) {
                let friction = told.friction.column(&format!("{interface}.friction [N]"));
                for (friction, share) in friction.iter().zip(share) {
                    assert!(*friction != 0.0 || *share == 0.0, "{name} {interface}");
                }
            }
        }
    }
    assert!(rows > 5000, "{rows}");
}

/// Returns the time step for about forty samples of a motion.
fn coarse(model: &ModelFile, motion: &str) -> Option<f64> {
    let duration = model.motion(motion).unwrap().duration;
    (duration > 0.0).then_some(duration / 40.0)
}

/// Tests the energy dissipated per cycle against two independent programs: 2.021 J with converged
/// friction, 1.955 J with decoupled friction. The contributions dissipate exactly this energy.
#[test]
fn the_regular_twin_dissipates_what_is_known() {
    let model = model("zhang2018-regular");
    for (friction, known) in [(FrictionMode::Converged, 2.021), (FrictionMode::OnePass, 1.955)] {
        let job = Job { step: Some(0.002), ..job(&model, "regular", "L0", friction) };
        let told = tell(&job);
        let dissipated = told.json["work"]["dissipated"].as_f64().unwrap();
        // The reference has three decimals; reversals limit the trapezoidal rule to the same
        // accuracy.
        assert!((dissipated - known).abs() < 1e-3, "{dissipated} {known}");
        let interfaces = told.json["friction"].as_object().unwrap();
        let parts =
            interfaces.values().map(|interface| interface["dissipated_part"].as_f64().unwrap());
        assert!((parts.sum::<f64>() - 1.0).abs() < 1e-12);
        // Each leg's own guide has the largest contribution to its actuator force.
        for leg in 1..=3 {
            let ranked = &told.json["drives"][format!("leg{leg}.P")]["friction_contributions"];
            let rms = |k: usize| ranked[k]["rms"].as_f64().unwrap();
            assert_eq!(ranked[0]["interface"], format!("leg{leg}.P"));
            assert!((1..7).all(|k| rms(k) <= rms(k - 1)));
            // These interfaces are all pins and balls. The guides of other legs contribute only to
            // the actuators of those legs.
            assert_eq!(ranked.as_array().unwrap().len(), 7);
        }
        assert!(told.text.contains("friction changes leg1.P by"), "{}", told.text);
    }
    let off = job(&model, "regular", "L0", FrictionMode::Off);
    assert!(!off.has_shares());
    let told = tell(&off);
    assert_eq!(told.json["efficiency"], Value::Null);
    assert!(!told.text.contains("efficiency"), "{}", told.text);
}

/// Returns the model of a block of 2 kg on a guide with the angle `slope` (degrees) and the
/// friction angle `rho`. The block moves up and down along the guide.
fn along_the_plane(slope: f64, rho: f64) -> String {
    let (sine, cosine) = slope.to_radians().sin_cos();
    let mu = rho.to_radians().tan();
    format!(
        r#"
        gravity = [0, "-9.81 m/s^2", 0]
        [bodies.block]
        mass = "2 kg"
        com = [0, 0, 0]
        inertia = ["0.01 kg m^2", "0.01 kg m^2", "0.01 kg m^2"]
        [joints.plane]
        type = "P"
        from = "ground"
        to = "block"
        axis = [{cosine:?}, {sine:?}, 0]
        friction = {{ mu = {mu:?} }}
        actuated = true
        [motions.up]
        duration = "1 s"
        step = "0.1 s"
        plane = "0.2 m/s*t"
        [motions.down]
        duration = "1 s"
        step = "0.1 s"
        plane = "-0.2 m/s*t"
        "#
    )
}

/// Returns the block of [`along_the_plane`] on the same guide, pushed by a body that moves
/// horizontally. This is the model of a wedge or a thread.
fn across_the_plane(slope: f64, rho: f64) -> String {
    let (sine, cosine) = slope.to_radians().sin_cos();
    let mu = rho.to_radians().tan();
    format!(
        r#"
        gravity = [0, "-9.81 m/s^2", 0]
        [bodies.block]
        mass = "2 kg"
        com = [0, 0, 0]
        inertia = ["0.01 kg m^2", "0.01 kg m^2", "0.01 kg m^2"]
        [bodies.pusher]
        [joints.plane]
        type = "P"
        from = "ground"
        to = "block"
        axis = [{cosine:?}, {sine:?}, 0]
        friction = {{ mu = {mu:?} }}
        [joints.push]
        type = "P"
        from = "ground"
        to = "pusher"
        axis = "x"
        actuated = true
        [joints.lift]
        type = "P"
        from = "pusher"
        to = "block"
        axis = "y"
        [motions.up]
        duration = "1 s"
        step = "0.1 s"
        push = "0.2 m/s*t"
        [motions.down]
        duration = "1 s"
        step = "0.1 s"
        push = "-0.2 m/s*t"
        "#
    )
}

static NO_LOAD: LoadCase =
    LoadCase { title: String::new(), wrenches: Vec::new(), laws: Vec::new(), payloads: Vec::new() };

/// Creates the job of a motion under gravity alone.
fn none_loaded<'a>(model: &'a ModelFile, motion: &str) -> Job<'a> {
    Job::new(model, (motion, model.motion(motion).unwrap()), ("none", &NO_LOAD))
}

/// Tests an inclined plane. With the guide at the angle a and the friction angle r, the force along
/// the guide is `W sin(a + r) / cos r` upward, `W sin(a - r) / cos r` downward, and `W sin a`
/// without friction. With a horizontal push, the forces are `W tan(a + r)`, `W tan(a - r)`,
/// `W tan a`. Efficiencies are ratios of these forces. For r >= a, the block is self-locking.
#[test]
fn an_inclined_plane_has_the_efficiencies_of_the_textbook() {
    let weight = 2.0 * 9.81;
    for (slope, rho) in [(20.0_f64, 5.0_f64), (30.0, 15.0), (5.0, 8.0), (40.0, 39.0), (12.0, 30.0)]
    {
        let (a, r) = (slope.to_radians(), rho.to_radians());
        let along = |angle: f64| angle.sin() / r.cos();
        let forces = [
            (along_the_plane(slope, rho), "plane", [along(a + r), a.sin(), along(a - r)]),
            (across_the_plane(slope, rho), "push", [(a + r).tan(), a.tan(), (a - r).tan()]),
        ];
        for (text, drive, [up, plain, down]) in forces {
            let model = model_of("plane", &text);
            for (motion, force) in [("up", up), ("down", down)] {
                let told = tell(&none_loaded(&model, motion));
                let found = told.inverse.column(&format!("{drive}.drive [N]"));
                let share = told.shares.column(&format!("{drive}.from.plane [N]"));
                for (found, share) in found.iter().zip(share) {
                    assert!((found - weight * force).abs() < 1e-11 * weight, "{found} {force}");
                    assert!((share - weight * (force - plain)).abs() < 1e-11 * weight);
                }
                let efficiency = &told.json["efficiency"];
                let near = |value: &Value, expected: f64, what: &str| {
                    let value = value.as_f64().unwrap();
                    assert!((value - expected).abs() < 1e-11, "{slope} {rho} {what} {value}");
                };
                if motion == "up" {
                    near(&efficiency["forward"], plain / up, "forward");
                } else if rho < slope {
                    // The actuator brakes the block and delivers no power.
                    assert_eq!(efficiency["forward"], Value::Null);
                } else {
                    // The actuator pushes a self-locking block down, and friction dissipates all of
                    // its power.
                    near(&efficiency["forward"], 0.0, "forward");
                }
                // The backward efficiency refers to the direction in which the load drives,
                // regardless of the direction of motion.
                let back = &efficiency["backward"][drive];
                near(&back["least"], (down / plain).max(0.0), "backward");
                near(&back["mean"], (down / plain).max(0.0), "backward");
                assert_eq!(back["samples"], 11);
                assert_eq!(back["samples_not_back_driven"], if rho < slope { 0 } else { 11 });
                let words = if rho < slope { "backward at least" } else { "at 11 of 11 samples" };
                assert!(told.text.contains(words), "{}", told.text);
            }
        }
    }
}

/// Tests a jack with a square thread of lead angle a under 50 kg, with an actuated spindle. The
/// torque is `W r tan(a + r)` for raising, `W r tan(a - r)` for lowering, and `W r tan a` without
/// friction.
#[test]
fn a_screw_jack_has_the_efficiencies_of_the_textbook() {
    for (lead, rho) in [(20.0_f64, 5.0_f64), (4.0, 3.9), (4.0, 6.0)] {
        let (a, r) = (lead.to_radians(), rho.to_radians());
        let text = format!(
            r#"
            gravity = [0, 0, "-9.81 m/s^2"]
            [bodies.spindle]
            mass = "50 kg"
            com = [0, 0, 0]
            inertia = ["0.01 kg m^2", "0.01 kg m^2", "0.01 kg m^2"]
            [joints.thread]
            type = "H"
            from = "ground"
            to = "spindle"
            axis = "z"
            pitch = {:?}
            friction = {{ mu = {:?}, radius = "10 mm", flank_angle = "0 deg" }}
            actuated = true
            [motions.up]
            duration = "1 s"
            step = "0.1 s"
            thread = "2 rad/s*t"
            "#,
            0.01 * a.tan(),
            r.tan()
        );
        let model = model_of("jack", &text);
        let told = tell(&none_loaded(&model, "up"));
        let torque = 50.0 * 9.81 * 0.01 * (a + r).tan();
        for drive in told.inverse.column("thread.drive [N m]") {
            assert!((drive - torque).abs() < 1e-11 * torque, "{drive} {torque}");
        }
        let efficiency = &told.json["efficiency"];
        let forward = efficiency["forward"].as_f64().unwrap();
        assert!((forward - a.tan() / (a + r).tan()).abs() < 1e-11, "{forward}");
        let back = &efficiency["backward"]["thread"];
        let expected = ((a - r).tan() / a.tan()).max(0.0);
        assert!((back["least"].as_f64().unwrap() - expected).abs() < 1e-10, "{back}");
        assert_eq!(back["samples_not_back_driven"], if rho < lead { 0 } else { 11 });
    }
}

/// Tests that a level guide returns no power and stores no energy.
#[test]
fn a_level_plane_has_no_load() {
    let model = model_of("plane", &along_the_plane(0.0, 10.0));
    let told = tell(&none_loaded(&model, "up"));
    assert_eq!(told.json["efficiency"]["forward"].as_f64(), Some(0.0));
    assert_eq!(told.json["efficiency"]["backward"]["plane"]["samples"], 0);
    assert_eq!(told.json["efficiency"]["backward"]["plane"]["least"], Value::Null);
    assert!(told.backward.iter().flatten().all(|back| *back == Backward::Undriven));
}

/// Tests a collar of weight W with its centre of mass 0.8 m from its guide. A rod moves the collar
/// at 0.2 m from the guide on the same side; the pads are 0.1 m apart and have a preload of 20/3 W.
/// For the upward motion, the actuator relieves the pads:
/// `d = (1 + 20/3 mu + 16 mu) / (1 + 4 mu) W` for every mu. For the downward motion, the actuator
/// must push and increases the load on the pads: `d = -(20/3 mu - 1 + 16 mu) / (1 - 4 mu) W`,
/// without a solution for mu >= 1/4.
#[test]
fn locking_against_back_driving_is_detected() {
    let text = |mu: f64| {
        format!(
            r#"
        gravity = [0, 0, "-9.81 m/s^2"]
        [bodies.collar]
        mass = "10 kg"
        com = ["0.8 m", 0, 0]
        inertia = ["0.1 kg m^2", "0.1 kg m^2", "0.1 kg m^2"]
        [bodies.rod]
        [bodies.driver]
        [joints.guide]
        type = "P"
        from = "ground"
        to = "collar"
        axis = "z"
        friction = {{ mu = {mu:?}, bending_span = "0.1 m", preload = "654 N" }}
        {}
        [motions.up]
        duration = "1 s"
        step = "0.1 s"
        drive = "0.1 m/s*t"
        "#,
            push_beside(0.2)
        )
    };
    let weight = 98.1;
    for mu in [0.2, 0.3] {
        let model = model_of("collar", &text(mu));
        let told = tell(&none_loaded(&model, "up"));
        let up = (1.0 + 20.0 / 3.0 * mu + 16.0 * mu) / (1.0 + 4.0 * mu) * weight;
        for drive in told.inverse.column("drive.drive [N]") {
            assert!((drive - up).abs() < 1e-10 * up, "{drive} {up}");
        }
        for backward in told.backward {
            match backward[0] {
                Backward::Driven { given, left } if mu < 0.25 => {
                    let push = (20.0 / 3.0 * mu - 1.0 + 16.0 * mu) / (1.0 - 4.0 * mu) * weight;
                    assert!((given - 0.1 * weight).abs() < 1e-10, "{given}");
                    assert!((left + 0.1 * push).abs() < 1e-10 * push, "{left} {push}");
                }
                Backward::Locked if mu > 0.25 => {}
                other => panic!("{mu}: {other:?}"),
            }
        }
        assert!(
            told.text.contains("cannot be back-driven by the load: drive at 11 of 11 samples"),
            "{}",
            told.text
        );
    }
}
