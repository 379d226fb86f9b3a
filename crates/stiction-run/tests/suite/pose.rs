//! Motion of zero duration, that is, a single pose: all results are available, and none is
//! undefined as a ratio of zeros.

use crate::common::tables;
use stiction_format::{LoadCase, ModelFile, Source, gallery, read};
use stiction_run::inverse::{Curves, Summary, Verdict, write_summary};
use stiction_run::{Job, Sink};

/// Returns the verdict, the summary as text and as JSON, the tables and the plots.
fn run(model: &ModelFile, motion: &str) -> (Verdict, String, serde_json::Value, Vec<String>) {
    let motion = Source::new("--motion", motion);
    let motion = model.parse_motion(&motion, &|_| Err(String::new())).unwrap();
    let load = LoadCase::default();
    let job = Job::new(model, ("pose", &motion), ("none", &load));
    let mut summary = Summary::new(&job);
    let mut curves = Curves::new(&job, 1);
    let mut tables = tables(&job);
    let verdict = job
        .run(|sample| (&mut summary, &mut curves, &mut tables).add(sample), |_, _, _| true)
        .unwrap();
    let mut text = String::new();
    write_summary(&mut text, &job, &summary, &verdict).unwrap();
    let tables = tables.finish().unwrap().into_iter().map(|file| String::from_utf8(file).unwrap());
    let figures = curves.figures().into_iter().map(|(_, figure)| figure.svg());
    let files = tables.chain(figures).collect();
    let json = summary.json(&job, &verdict);
    (verdict, text, json, files)
}

fn robot() -> ModelFile {
    let text = gallery::get("3rps").unwrap();
    read(&Source::new("3rps.toml", text), &|_| Err(String::new())).unwrap()
}

#[test]
fn nothing_is_undefined() {
    for z in ["500 mm", "500 mm + 0.1 m/s*t"] {
        let motion = format!("duration = 0; platform.z = {z}; platform.rx = 0; platform.ry = 0");
        let (verdict, text, json, files) = run(&robot(), &motion);
        assert_eq!(verdict.samples, 1);
        assert_eq!(files.len(), 11);
        for file in files.iter().chain([&text]) {
            for word in ["NaN", "nan", "inf"] {
                assert!(!file.contains(word), "{word} in {file}");
            }
        }
        assert_eq!(json["options"]["samples"], 1);
        // Work over zero time vanishes; the power does not.
        assert_eq!(json["work"]["drives"], 0.0);
        assert!(json["verdicts"]["distance_actuation"]["least"].is_number());
        assert!(json["drives"]["leg1.P"]["with_friction"]["rms"].is_number());
        assert!(text.contains(" W") && !text.contains(" J"), "{text}");
    }
}

/// Tests a reversal, at which rounding leaves rates of 1e-17. These rates must not count as
/// sliding.
#[test]
fn a_reversal_is_rest() {
    let tilts = "platform.rx = 0; platform.ry = 0";
    let z = "platform.z = 500 mm + 30 mm*cos(2*pi*t)";
    let motion = format!("start = 0.5 s; duration = 0; {z}; {tilts}");
    let (_, text, json, _) = run(&robot(), &motion);
    assert_eq!(json["verdicts"]["samples_at_rest"], 1, "{text}");
}
