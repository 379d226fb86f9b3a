//! Results do not depend on the number of threads or on the division of the motion into pieces.

use crate::common::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_format::{ModelFile, gallery};
use stiction_run::inverse::{Sample, Summary, Verdict};
use stiction_run::{Error, Job, Sink};

/// Returns all tables, the summary and the verdict of a run, as written.
fn run(job: &Job<'_>, threads: usize) -> Result<(Vec<Vec<u8>>, Verdict), Error> {
    let mut tables = tables(job);
    let mut summary = Summary::new(job);
    let mut last = None;
    let receive = |sample: &Sample| (&mut tables, &mut summary).add(sample);
    let progress = |phase, done, of| {
        assert!(done <= of);
        last = Some((phase, done, of));
        true
    };
    let verdict = job.run_on(threads, receive, progress)?;
    let (_, done, of) = last.unwrap();
    assert_eq!((done, of), (verdict.samples, verdict.samples));
    let json = summary.json(job, &verdict).to_string().into_bytes();
    let mut files = tables.finish().unwrap();
    files.push(json);
    Ok((files, verdict))
}

/// Creates the job of a gallery model with its default motion in a given number of samples.
fn finely<'a>(model: &'a ModelFile, friction: FrictionMode, samples: usize) -> Job<'a> {
    let job = default_job(model, friction);
    let step = job.motion.duration / (samples - 1) as f64;
    Job { step: Some(step), ..job }
}

/// Tests that all results are equal byte by byte, for robots with and without redundant
/// constraints, with interfaces at rest and with turning cranks.
#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    for (name, samples) in
        [("3rps", 1300), ("zhang2018-regular", 1100), ("slider-crank", 2000), ("four-bar", 600)]
    {
        let model = model(name);
        let job = finely(&model, FrictionMode::Converged, samples);
        let (alone, verdict) = run(&job, 1).unwrap();
        assert_eq!(verdict.samples, samples, "{name}");
        for threads in [2, 3, 7] {
            let (files, same) = run(&job, threads).unwrap();
            assert!(files == alone, "{name}, {threads} threads");
            assert_eq!(same, verdict, "{name}, {threads} threads");
        }
    }
}

/// Tests that errors do not depend on the number of threads: the first error in time is reported,
/// regardless of which thread finds an error first.
#[test]
fn errors_do_not_depend_on_the_number_of_threads() {
    let model = model("zhang2018");
    let job = finely(&model, FrictionMode::Converged, 700);
    let message = |threads| run(&job, threads).unwrap_err().to_string();
    let alone = message(1);
    for threads in [2, 5] {
        assert_eq!(message(threads), alone);
    }
    // A cancelled run ends promptly.
    let robot = crate::common::model("3rps");
    let job = finely(&robot, FrictionMode::Off, 3000);
    let stopped = job.run_on(3, |_| Ok(()), |_, done, _| done < 700);
    assert!(matches!(stopped, Err(Error::Interrupted)));
    let refused = job.run_on(2, |_| Err("full".into()), |_, _, _| true);
    assert!(matches!(refused, Err(Error::Receiver(_))));
}

/// Tests that pieces start at the positions of a motion followed sample by sample, even if a long
/// step covers whole turns of a crank.
#[test]
fn chunks_start_on_the_motion() {
    let fast = "\n[motions.fast]\nduration = \"2 s\"\nA = \"60 deg + 62.5*360 deg*t\"\n";
    let four_bar = gallery::get("four-bar").unwrap().to_owned() + fast;
    let (four_bar, robot) = (model_of("four-bar", &four_bar), model("3rps"));
    let jobs = [
        job(&four_bar, "fast", four_bar.default_load.as_ref().unwrap(), FrictionMode::Off),
        default_job(&robot, FrictionMode::Off),
    ];
    for job in jobs {
        // The crank turns once in sixteen samples.
        let job = Job { step: Some(job.motion.duration / 2000.0), ..job };
        let (name, motion) = (&job.model.name, job.motion);
        let mut found = Vec::new();
        let receive = |sample: &Sample| {
            found.push((sample.time, sample.forces.efforts.clone()));
            Ok(())
        };
        job.run(receive, |_, _, _| true).unwrap();
        assert_eq!(found.len(), 2001);
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let at = |t: f64| motion.at(t).collect::<Vec<_>>();
        let mut before = found[0].0;
        let mut solver = InverseDynamics::new(
            job.model.mechanism.clone(),
            &job.model.initial_poses,
            &coordinates,
            &at(before),
            Settings { friction: FrictionMode::Off, ..Settings::default() },
        )
        .unwrap();
        for (time, drives) in found {
            let targets = |t, targets: &mut [_]| targets.clone_from_slice(&at(t));
            solver.follow(before, time, targets).unwrap();
            before = time;
            let loads: Vec<_> = job.load.at(time).collect();
            let expected = &solver.solve(&loads).unwrap().efforts;
            let largest = expected.iter().fold(1.0_f64, |most, drive| most.max(drive.abs()));
            for (drive, expected) in drives.iter().zip(expected) {
                // Newton's method ends at 1e-14; forces amplify the errors of positions.
                assert!((drive - expected).abs() < 1e-11 * largest, "{name} at {time}");
            }
        }
    }
}
