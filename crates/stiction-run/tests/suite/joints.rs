//! Motion of joints, actuators and legs in the tables.

use crate::common::{Csv, Run, default_job, files, job, model, model_of, regular, tables};
use stiction_core::dynamics::FrictionMode;
use stiction_run::inverse::{Summary, write_summary};
use stiction_run::{Job, Sink};

fn joints(job: &Job<'_>) -> Csv {
    let mut tables = tables(job);
    job.run(|sample| tables.add(sample), |_, _, _| true).unwrap();
    Csv::parse(&files(job, tables)["joints.csv"])
}

/// Tests that rates are the derivatives of coordinates, and accelerations those of rates, also
/// across full turns.
#[test]
fn rates_and_accelerations_are_derivatives() {
    let mut seen = 0;
    for name in regular() {
        let model = model(name);
        // The fastest mechanism turns by a radian in a few milliseconds.
        let step = 1e-5;
        let fine = Job { step: Some(step), ..default_job(&model, FrictionMode::Off) };
        let duration = fine.motion.duration.min(0.002);
        let mut motion = fine.motion.clone();
        motion.duration = duration;
        if motion.samples.is_some() {
            continue;
        }
        let csv = joints(&Job { motion: &motion, ..fine });
        for (value, derivative) in [("position", "rate"), ("rate", "acceleration")] {
            for (column, values) in csv.columns() {
                let Some((joint, unit)) = column.split_once(&format!(".{value} [")) else {
                    continue;
                };
                let of = |unit: &str| format!("{joint}.{derivative} [{unit}]");
                let unit = unit.trim_end_matches(']');
                let rates = match (value, unit) {
                    ("position", unit) => csv.column(&of(&format!("{unit}/s"))),
                    (_, unit) => csv.column(&of(&format!("{unit}^2"))),
                };
                let largest = rates.iter().fold(1e-3_f64, |most, rate| most.max(rate.abs()));
                for k in 1..values.len() - 1 {
                    let found = (values[k + 1] - values[k - 1]) / (2.0 * step);
                    let error = (found - rates[k]).abs();
                    assert!(error < 2e-4 * largest, "{name} {column}: {found} {}", rates[k]);
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 10_000, "{seen}");
}

/// Tests that the length of a Stewart platform's leg is the coordinate of its slide plus a
/// constant, and that a prescribed angle keeps its full turns.
#[test]
fn legs_and_full_turns() {
    let model = model("gough");
    let csv = joints(&default_job(&model, FrictionMode::Off));
    let (slide, length) = (csv.column("leg1.P.position [m]"), csv.column("leg1.length [m]"));
    let offset = length[0] - slide[0];
    for (slide, length) in slide.iter().zip(length) {
        assert!((length - slide - offset).abs() < 1e-9, "{slide} {length}");
    }

    let text = "gravity = [0, 0, 0]\n[bodies.bob]\nmass = 1\ncom = [0.1, 0, 0]\ninertia = [0, 0.01, 0.01]\n\
                [joints.pivot]\ntype = \"R\"\nfrom = \"ground\"\nto = \"bob\"\naxis = \"z\"\n\
                actuated = true\n[motions.turn]\nduration = 2\nstep = 0.5\npivot = \"400 deg/s*t\"\n\
                [loads.none]\n";
    let model = model_of("turns", text);
    let csv = joints(&job(&model, "turn", "none", FrictionMode::Off));
    for (k, angle) in csv.column("pivot.position [rad]").iter().enumerate() {
        let expected = (200.0 * k as f64).to_radians();
        assert!((angle - expected).abs() < 1e-12, "{angle} {expected}");
    }
}

/// Tests that the powers of the actuators add up to the actuator power in the power balance.
#[test]
fn actuators_have_the_power_of_the_drives() {
    for name in ["gough", "five-bar", "zhang2018-regular"] {
        let model = model(name);
        let job = default_job(&model, FrictionMode::Converged);
        let mut of_drives = Vec::new();
        job.run(
            |sample| {
                of_drives.push(sample.forces.power.actuators);
                Ok(())
            },
            |_, _, _| true,
        )
        .unwrap();
        let run = Run::of(&job).unwrap();
        let largest = of_drives.iter().fold(0.0_f64, |most, power| most.max(power.abs()));
        for (k, power) in of_drives.iter().enumerate() {
            let columns = run.inverse.columns();
            let own =
                columns.filter(|(name, _)| name.ends_with(".power [W]")).map(|(_, all)| all[k]);
            assert!((own.sum::<f64>() - power).abs() < 1e-12 * largest, "{name}");
        }
    }
}

/// Tests that the summary of a block at rest on a slope contains the interval of the effort: the
/// weight component minus and plus the static friction limit.
#[test]
fn the_summary_has_the_interval_at_rest() {
    let text = "gravity = [0, 0, -10]\n[bodies.block]\nmass = 2\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n[joints.slide]\ntype = \"P\"\n\
                from = \"ground\"\nto = \"block\"\naxis = \"x\"\nactuated = true\n\
                friction = { mu = 0.1, mu_static = 0.3 }\n[motions.stand]\nduration = 0\nslide = 0\n\
                [loads.none]\n";
    let model = model_of("block", text);
    let job = job(&model, "stand", "none", FrictionMode::Converged);
    let mut summary = Summary::new(&job);
    let add = |sample: &stiction_run::inverse::Sample| {
        summary.add(sample)?;
        Ok(())
    };
    let verdict = job.run(add, |_, _, _| true).unwrap();
    let mut text = String::new();
    write_summary(&mut text, &job, &summary, &verdict).unwrap();
    assert!(text.contains("joints at rest at 1 sample; widest intervals"), "{text}");
    assert!(text.contains("slide               -6.000 to       6.000 N at t = 0 s"), "{text}");
    let json = summary.json(&job, &verdict);
    assert_eq!(json["drives"]["slide"]["speed"]["peak"], 0.0);
    assert_eq!(json["drives"]["slide"]["position"]["least"], 0.0);
}
