//! Warm starts: each sample along a motion starts from the previous samples, and a run without
//! tables computes singularity indices only where they may be least. Neither changes results or
//! verdicts.

use crate::common::*;
use serde_json::Value;
use stiction_core::dynamics::{FrictionMode, Settings};
use stiction_core::kinematics::Target;
use stiction_run::inverse::{Sample, Summary};
use stiction_run::{Indices, Job, Sink};

/// Returns the samples of a run, and its summary.
fn run(job: &Job<'_>) -> (Vec<Sample>, Value, f64) {
    let (mut samples, mut summary) = (Vec::new(), Summary::new(job));
    let receive = |sample: &Sample| {
        samples.push(sample.clone());
        summary.add(sample)
    };
    let verdict = job.run(receive, |_, _, _| true).unwrap();
    (samples, summary.json(job, &verdict), verdict.rest_speed)
}

/// Tests that the efforts, with and without friction, equal those of the kernel for each sample
/// alone, starting from the home position and without data of other samples.
#[test]
fn efforts_are_those_of_the_kernel() {
    let mut compared = 0;
    for name in regular() {
        let model = model(name);
        for (motion, load) in cases(&model) {
            let friction = FrictionMode::Converged;
            let job = job(&model, motion, load, friction);
            let (samples, _, rest_speed) = run(&job);
            let mut follower = job.assemble(samples[0].time).unwrap();
            let every = (samples.len() / 6).max(1);
            for sample in samples.iter().step_by(every) {
                follower.go_to(sample.time).unwrap();
                // At rest the kernel converges without static friction, as the run does.
                let settings = Settings { friction, rest_speed, ..Settings::default() };
                let Ok(compiled) = follower.solver.model() else { continue };
                let mut data = compiled.data(follower.solver.state(), settings);
                let targets: Vec<Target<f64>> = job.motion.at(sample.time).collect();
                let parameters = follower.solver.parameters();
                compiled.evaluate(parameters, &mut data, &targets, &sample.loads);
                if sample.coupling.is_none_or(|coupling| coupling >= 1.0) {
                    continue;
                }
                let pairs = [
                    (data.inverse.efforts(), &sample.forces.efforts),
                    (data.inverse.efforts_frictionless(), &sample.forces.efforts_frictionless),
                ];
                for (expected, found) in pairs {
                    let largest = found.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
                    for (expected, found) in expected.iter().zip(found) {
                        let error = (expected - found).abs() / largest;
                        // Rounding of a balance is below 1e-13; loops are closed to 1e-14.
                        assert!(error < 1e-12, "{name} {motion} {}: {error:.1e}", sample.time);
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

/// Tests the friction coupling and the efforts in dense samples. The greatest bound on the coupling
/// equals that of a run that computes the least bound at every sample, although a run without
/// tables accepts greater bounds in between. In samples so dense that extrapolated normal loads
/// require no Newton step, the efforts equal those of the kernel.
#[test]
fn dense_samples_agree_with_the_kernel_and_with_tables() {
    for (name, step) in [("3rps", 2e-4), ("slider-crank", 1e-3), ("gough", 4e-3)] {
        let model = model(name);
        let job = default_job(&model, FrictionMode::Converged);
        let all = Job { step: Some(step), ..job };
        let least_job = Job { indices: Indices::Least, ..all.clone() };
        let [(samples, all, rest_speed), (others, least, _)] = [run(&all), run(&least_job)];
        let of = |summary: &Value| summary["verdicts"]["friction_coupling"].as_f64().unwrap();
        let (expected, found) = (of(&all), of(&least));
        // Lower and upper bounds agree to 1e-13.
        assert!((found - expected).abs() <= 1e-12 * expected, "{name}: {found} {expected}");
        for (sample, other) in samples.iter().zip(&others) {
            let [exact, bound] = [sample, other].map(|sample| sample.coupling.unwrap());
            assert!(bound >= exact * (1.0 - 1e-12), "{name} {}: {bound} {exact}", sample.time);
            assert!(bound <= expected * (1.0 + 1e-12), "{name} {}: {bound}", sample.time);
        }
        let mut follower = least_job.assemble(samples[0].time).unwrap();
        for sample in samples.iter().step_by(samples.len() / 7) {
            follower.go_to(sample.time).unwrap();
            *follower.solver.settings_mut() =
                Settings { friction: FrictionMode::Converged, rest_speed, ..Settings::default() };
            let efforts = follower.solver.solve(&sample.loads).unwrap().efforts.clone();
            let largest = efforts.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
            for (expected, found) in efforts.iter().zip(&sample.forces.efforts) {
                let error = (expected - found).abs() / largest;
                assert!(error < 1e-12, "{name} {}: {error:.1e}", sample.time);
            }
        }
    }
}

/// Tests that a dwell is solved once in each piece: its samples are equal to each other and to
/// those of a mechanism at rest.
#[test]
fn samples_of_a_dwell_are_those_of_rest() {
    let still = "\n[motions.still]\nduration = \"1 s\"\nplatform.z = \"home_height\"\n\
                 platform.rx = \"0 rad\"\nplatform.ry = \"0 rad\"\n";
    let text = stiction_format::gallery::get("3rps").unwrap().to_owned() + still;
    let model = model_of("3rps", &text);
    let load = model.default_load.as_ref().unwrap();
    for indices in [Indices::All, Indices::Least] {
        let job = job(&model, "still", load, FrictionMode::Converged);
        let job = Job { step: Some(2e-3), indices, ..job };
        let (samples, _, rest_speed) = run(&job);
        let instants = job.instants().unwrap();
        assert_eq!(samples.len(), instants.count());
        let mut follower = job.assemble(0.0).unwrap();
        *follower.solver.settings_mut() =
            Settings { friction: FrictionMode::Converged, rest_speed, ..Settings::default() };
        let expected = follower.solver.solve(&samples[0].loads).unwrap().clone();
        assert!(expected.effort_bounds.iter().all(|(low, high)| low < high));
        for (k, sample) in samples.iter().enumerate() {
            assert_eq!(sample.time, instants.at(k));
            let pairs = expected.effort_bounds.iter().zip(&sample.forces.effort_bounds);
            for (expected, found) in pairs {
                let size = expected.0.abs() + expected.1.abs();
                let error = (expected.0 - found.0).abs() + (expected.1 - found.1).abs();
                assert!(error <= 1e-12 * size, "{k}: {found:?} {expected:?}");
            }
            assert_eq!(sample.forces.bounds, expected.bounds, "{k}");
            if k > 0 {
                // Each piece begins with a new solution, so pieces differ by rounding.
                let same = sample.forces.efforts == samples[k - 1].forces.efforts;
                assert!(same || k % 256 == 0, "{k}");
            }
        }
        let known = |sample: &&Sample| sample.distances.actuation.is_finite();
        assert_eq!(samples.iter().filter(known).count(), samples.len());
    }
}

/// Tests that the least indices and their instants equal those of a run that computes all indices.
#[test]
fn the_least_indices_are_those_of_all_samples() {
    let (mut left_out, mut total) = (0, 0);
    for name in regular() {
        let model = model(name);
        for (motion, load) in cases(&model) {
            let all = job(&model, motion, load, FrictionMode::Off);
            let least = Job { indices: Indices::Least, ..all.clone() };
            let [(_, all, _), (samples, least, _)] = [run(&all), run(&least)];
            for (key, expected) in all["verdicts"].as_object().unwrap() {
                let found = &least["verdicts"][key];
                let numbers =
                    |value: &Value| Some((value["least"].as_f64()?, value["time"].as_f64()));
                match (numbers(expected), numbers(found)) {
                    (Some((expected, at)), Some((found, time))) => {
                        // Values are accurate to 1e-9, so instants of nearly equal indices may be
                        // exchanged.
                        let error = (found - expected).abs() / expected.max(f64::MIN_POSITIVE);
                        assert!(error < 1e-9, "{name} {motion} {key}: {found} {expected}");
                        assert!(error > 0.0 || time == at, "{name} {motion} {key}");
                    }
                    _ => assert_eq!(found, expected, "{name} {motion} {key}"),
                }
            }
            total += samples.len();
            left_out += samples.iter().filter(|sample| sample.distances.actuation.is_nan()).count();
        }
    }
    // The test is meaningful only if many indices are left out.
    assert!(left_out * 100 > total, "{left_out} of {total}");
}
