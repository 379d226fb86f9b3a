//! Motions and efforts from recordings that are read piece by piece.

use crate::common::*;
use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use stiction_core::dynamics::FrictionMode;
use stiction_format::{Contents, Drives, LoadCase, ModelFile, Motion, Source, Store};
use stiction_run::forward::{self, Ending, Feed, Start};
use stiction_run::{Error, Job};

/// File whose content changes after a given number of bytes has been read.
#[derive(Debug)]
struct Spoilt {
    bytes: Mutex<Vec<u8>>,
    left: AtomicUsize,
}

impl Store for Spoilt {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, String> {
        let mut bytes = self.bytes.lock().unwrap();
        if self.left.load(Ordering::Relaxed) == 0 {
            bytes.fill(b'\n');
        }
        let rest = bytes.get(offset as usize..).unwrap_or_default();
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        let left = self.left.load(Ordering::Relaxed);
        self.left.store(left.saturating_sub(count), Ordering::Relaxed);
        Ok(count)
    }
}

fn spoilt(text: &str, after: usize) -> Contents {
    let (bytes, left) = (Mutex::new(text.as_bytes().to_vec()), AtomicUsize::new(after));
    Contents::Stored(Arc::new(Spoilt { bytes, left }))
}

fn stored(text: &str) -> Contents {
    spoilt(text, usize::MAX)
}

/// Number of samples that fill three windows of a recording.
const COUNT: usize = 13_000;

/// Returns a recording of the crank of a four-bar linkage, or of a force on it, with a sample every
/// millisecond.
fn recording(column: &str, value: impl Fn(f64) -> f64) -> String {
    let mut text = format!("time [s], {column}\n");
    for k in 0..COUNT {
        let time = k as f64 * 1e-3;
        writeln!(text, "{time}, {}", value(time)).unwrap();
    }
    text
}

fn turning() -> String {
    recording("A [rad]", |t| 1.0 + 0.3 * (2.0 * t).sin())
}

fn motion(model: &ModelFile, contents: &Contents) -> Motion {
    let files = |_: &str| Ok(contents.clone());
    model.parse_motion(&Source::new("--motion", "turn.csv"), &files).unwrap()
}

fn drives(model: &ModelFile, contents: &Contents) -> Drives {
    let files = |_: &str| Ok(contents.clone());
    model.parse_drives(&Source::new("--drives", "drive.csv"), &files).unwrap()
}

/// Returns the actuator forces at all samples, as bit patterns.
fn follow(model: &ModelFile, motion: &Motion, threads: usize) -> Result<Vec<(u64, u64)>, Error> {
    let job = Job { motion, ..default_job(model, FrictionMode::Off) };
    let mut found = Vec::new();
    job.run_on(
        threads,
        |sample| {
            found.push((sample.time.to_bits(), sample.forces.efforts[0].to_bits()));
            assert!(sample.time.is_finite() && sample.forces.efforts[0].is_finite());
            Ok(())
        },
        |_, _, _| true,
    )
    .map(|_| found)
}

#[test]
fn forces_are_the_same_on_several_threads() {
    let (model, text) = (model("four-bar"), turning());
    let whole = follow(&model, &motion(&model, &text.as_str().into()), 1).unwrap();
    assert_eq!(whole.len(), COUNT);
    let pieces = follow(&model, &motion(&model, &stored(&text)), 3).unwrap();
    assert!(whole == pieces, "drives differ");
}

/// Tests that an overwritten file is reported at any point of the run, and that none of its new
/// data are used.
#[test]
fn a_file_that_is_overwritten_stops_the_motion() {
    let (model, text) = (model("four-bar"), turning());
    for threads in [1, 4] {
        // The file is read once completely, then in windows. Its content changes before the first,
        // second and third window.
        for part in [1.0, 1.01, 1.5] {
            let after = (part * text.len() as f64) as usize;
            let error = follow(&model, &motion(&model, &spoilt(&text, after)), threads);
            let fault = match error {
                Err(Error::NotFinite(fault)) => fault,
                Err(other) => panic!("{part}: {other}"),
                Ok(samples) => panic!("{part}: {} samples", samples.len()),
            };
            assert!(fault.message.contains("it has changed"), "{}", fault.message);
        }
    }
}

/// Simulates the crank with inputs from recordings.
fn simulate(
    model: &ModelFile,
    motion: &Motion,
    drives: &Drives,
    prescribed: bool,
) -> (usize, Ending) {
    let load = LoadCase::default();
    let job = forward::Job {
        motion: Some(motion),
        drives: Feed::Given(drives),
        prescribed: if prescribed { vec![0] } else { Vec::new() },
        start: Start::Moving,
        until: 6.0,
        step: 0.5,
        ..forward::Job::new(model, ("none", &load))
    };
    let mut samples = 0;
    let receive = |sample: &forward::Sample<'_>, _: &dyn Fn() -> forward::RunCheckpoint| {
        assert!(sample.joints.iter().all(|joint| joint.value.is_finite()));
        samples += 1;
        Ok(())
    };
    let outcome = job.run(receive, &|| false, None).unwrap();
    (samples, outcome.ending)
}

#[test]
fn overwritten_files_are_reported() {
    let model = model("four-bar");
    let turning = turning();
    let pushing = recording("A [N m]", |t| 0.1 * t.sin());
    let (turns, pushes) = (motion(&model, &stored(&turning)), drives(&model, &stored(&pushing)));
    let none = Drives::default();
    for (prescribed, given) in [(true, &none), (false, &pushes)] {
        let (samples, ending) = simulate(&model, &turns, given, prescribed);
        assert!(matches!(ending, Ending::Reached), "{ending:?}");
        assert_eq!(samples, 13);
    }
    // The content changes after the first complete pass and a further quarter of the text.
    let after = |text: &str| text.len() + text.len() / 4;
    let spoilt_turns = motion(&model, &spoilt(&turning, after(&turning)));
    let spoilt_pushes = drives(&model, &spoilt(&pushing, after(&pushing)));
    for (prescribed, motion, given) in
        [(true, &spoilt_turns, &none), (false, &turns, &spoilt_pushes)]
    {
        let (samples, ending) = simulate(&model, motion, given, prescribed);
        let Ending::Failed(error) = ending else { panic!("{ending:?}") };
        let Error::NotFinite(fault) = *error else { panic!("{error:?}") };
        assert!(fault.message.contains("it has changed"), "{}", fault.message);
        assert!((1..13).contains(&samples), "{samples}");
    }
}
