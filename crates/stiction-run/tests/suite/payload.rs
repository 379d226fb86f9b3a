//! Payloads: parts that a body carries, with weight and inertia.

use crate::common::{MODES, Run, job, model_of, slide};
use stiction_core::mechanism::Body;
use stiction_core::spatial::{Mat3, Vec3};
use stiction_format::{Drives, LoadCase, ModelFile, Source, gallery};
use stiction_run::forward::{Ending, Feed, Job};

/// Reads a model of the gallery with an additional load `part`.
fn with_part(name: &str, part: &str) -> ModelFile {
    let text = gallery::get(name).unwrap();
    let loads = format!("[loads.empty]\ntitle = \"\"\n[[loads.part.payload]]\n{part}");
    model_of(name, &format!("{text}\n{loads}"))
}

const PART: &str = "mass = \"1.2 kg\"\ncom = [\"10 mm\", \"-5 mm\", \"-60 mm\"]\n\
                    inertia = [\"2e-3 kg m^2\", \"3e-3 kg m^2\", \"1e-3 kg m^2\"]\n";

fn part() -> Body {
    Body {
        name: "part".into(),
        mass: 1.2,
        com: Vec3::new(0.01, -0.005, -0.06),
        inertia: Mat3::diagonal(Vec3::new(2e-3, 3e-3, 1e-3)),
    }
}

/// Tests that a permanent payload is equivalent to a heavier body, with and without friction.
#[test]
fn a_payload_equals_a_heavier_body() {
    for (name, body, motion) in [
        ("delta", "platform", "pick-and-place"),
        ("five-bar", "tool", "pick-and-place"),
        ("gough", "platform", "heave"),
    ] {
        let carrying = with_part(name, &format!("body = \"{body}\"\n{PART}"));
        let motion = carrying
            .motion(motion)
            .map_or_else(|| carrying.default_motion.clone().unwrap(), |_| motion.to_owned());
        let mut heavier = carrying.clone();
        let id = heavier.mechanism.body_id(body).unwrap();
        heavier.mechanism = heavier.mechanism.with_payload(id, &part());
        for friction in MODES {
            let run = Run::of(&job(&carrying, &motion, "part", friction)).unwrap();
            let expected = Run::of(&job(&heavier, &motion, "empty", friction)).unwrap();
            for (name, column) in run.inverse.columns().filter(|(name, _)| name.contains(".drive"))
            {
                let expected = expected.inverse.column(name);
                let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                for (a, b) in column.iter().zip(expected) {
                    // Tolerance for rounding, and for the convergence of iterated friction.
                    assert!((a - b).abs() < 1e-9 * scale, "{name}: {a} {b}");
                }
            }
            assert!(run.power_residual < 1e-9, "{}", run.power_residual);
        }
    }
}

/// Tests that the table has two rows for the instant at which a part is picked up or placed: the
/// values before and after the change.
#[test]
fn forces_jump_where_a_part_is_picked_up() {
    let body = format!("body = \"platform\"\n{PART}");
    let always = with_part("delta", &body);
    let times = "from = \"0.1 s\"\nuntil = \"0.4 s\"\n";
    let picking = with_part("delta", &format!("{body}{times}"));
    for friction in MODES {
        let of = |model: &ModelFile, load: &str| {
            Run::of(&job(model, "pick-and-place", load, friction)).unwrap().inverse
        };
        let (with, without) = (of(&always, "part"), of(&always, "empty"));
        let found = of(&picking, "part");
        let effort = found.columns().find(|(name, _)| name.ends_with(".drive [N m]"));
        let (name, effort) = effort.unwrap();
        let found_times = found.column("time [s]");
        assert_eq!(effort.len(), without.column(name).len() + 2);
        let mut row = 0;
        for (k, &time) in without.column("time [s]").iter().enumerate() {
            let (empty, full) = (without.column(name)[k], with.column(name)[k]);
            let expected: &[f64] = match time {
                t if (t - 0.1).abs() < 1e-9 => &[empty, full],
                t if (t - 0.4).abs() < 1e-9 => &[full, empty],
                t if t > 0.1 && t < 0.4 => &[full],
                _ => &[empty],
            };
            for expected in expected {
                assert_eq!(found_times[row], time);
                assert!((effort[row] - expected).abs() < 1e-9, "{time}: {}", effort[row]);
                row += 1;
            }
        }
    }
}

/// Tests a part of 3 kg on a slide of 2 kg that is pushed by 10 N: the acceleration is 2 m/s^2.
#[test]
fn a_simulated_slide_carries_a_part() {
    let loads = r#"
        [[loads.always.payload]]
        body = "mass"
        mass = "3 kg"
        [[loads.placed.payload]]
        body = "mass"
        mass = "3 kg"
        until = "0.5 s"
    "#;
    let model = slide("", loads);
    let none = |_: &str| Err("no files".to_owned());
    let drives: Drives =
        model.parse_drives(&Source::new("--drives", "slide = 10 N"), &none).unwrap();
    let run = |load: &LoadCase| {
        let drives = Feed::Given(&drives);
        let job = Job { drives, until: 1.0, step: 0.5, ..Job::new(&model, ("load", load)) };
        let mut positions = Vec::new();
        let outcome = job.run(
            |sample, _| {
                positions.push(sample.instant.state.coordinates[0]);
                Ok(())
            },
            &|| false,
            None,
        );
        outcome.map(|outcome| {
            assert!(matches!(outcome.ending, Ending::Reached));
            positions
        })
    };
    let positions = run(model.load("always").unwrap()).unwrap();
    for (found, expected) in positions.iter().zip([0.0, 0.25, 1.0]) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
    // The part leaves with its velocity, and the same force then moves 2 kg.
    let positions = run(model.load("placed").unwrap()).unwrap();
    for (found, expected) in positions.iter().zip([0.0, 0.25, 1.375]) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}
