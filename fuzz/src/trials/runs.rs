//! Runs of models: every accepted model must produce finite results or an error.

use super::finite;
use super::texts::model_of;
use std::time::{Duration, Instant};
use stiction_core::dynamics::FrictionMode;
use stiction_format::{Control, LoadCase, ModelFile, Motion, Source};
use stiction_run::exchange::{Home, json_text, mjcf};
use stiction_run::{Job, Sink, breakaway, check, forward, inverse};

/// Samples of a run.
const SAMPLES: f64 = 3.0;
/// Time limit of a motion; a run that does not stop after it is a finding.
const PATIENCE: Duration = Duration::from_secs(1);
/// Maximum duration of a simulation, s.
const SPAN: f64 = 0.05;

/// Returns the motion and the load that the command line uses by default.
fn asked(model: &ModelFile) -> Option<(Motion, LoadCase)> {
    let motion = match &model.default_motion {
        Some(name) => model.motion(name)?,
        None => &model.motions.first()?.1,
    };
    let load = match &model.default_load {
        Some(name) => model.load(name),
        None => model.loads.first().map(|(_, load)| load),
    };
    Some((motion.clone(), load.cloned().unwrap_or_default()))
}

/// Runs all commands on a model file.
pub fn mechanism(text: &str) {
    let Some(model) = model_of(text) else { return };
    let Some((motion, load)) = asked(&model) else { return };
    let step = if motion.duration > 0.0 { motion.duration / SAMPLES } else { 1.0 };
    let job = |friction| Job {
        friction,
        step: Some(step),
        ..Job::new(&model, ("motion", &motion), ("load", &load))
    };
    checked(&job(FrictionMode::Off));
    converted(&job(FrictionMode::Off));
    for friction in [FrictionMode::Off, FrictionMode::OnePass] {
        inverse(&job(friction));
    }
    inverse(&Job { friction_margin: true, ..job(FrictionMode::Converged) });
    stopped(&job(FrictionMode::Converged));
    simulated(&model, &motion, &load);
}

fn patient() -> impl FnMut(inverse::Phase, usize, usize) -> bool {
    let begun = Instant::now();
    move |_, _, _| begun.elapsed() < PATIENCE
}

fn checked(job: &Job<'_>) {
    let findings = match check::examine(job, patient()) {
        Ok(findings) => findings,
        Err(error) => return finite::text("a reason", &error.to_string()),
    };
    let mut text = String::new();
    check::write_report(&mut text, job, &findings).expect("a string takes it");
    finite::text("check", &text);
    const EMPTY: &[&str] = &[
        "finite_motion",
        "leg",
        "weakest",
        "everywhere",
        "actuation_of_motion",
        "left",
        "smallest_kept",
        "largest_dropped",
        "distance",
        "greatest_elsewhere",
    ];
    finite::json("check", &findings.json(job), EMPTY);
    if let Ok(page) = check::draw_page(job, &findings, None) {
        finite::picture("mechanism.svg", &page.picture);
    }
}

fn converted(job: &Job<'_>) {
    let Ok(home) = Home::of(job) else { return };
    let json = serde_json::from_str(&json_text(&home)).expect("it is JSON");
    const EMPTY: &[&str] = &["friction", "compliance", "coordinate"];
    finite::json("convert", &json, EMPTY);
    match mjcf(&home) {
        Ok(converted) => finite::picture("mjcf", &converted.text),
        Err(unfit) => assert!(!unfit.to_string().is_empty() && !unfit.help().is_empty()),
    }
}

fn inverse(job: &Job<'_>) {
    let names = inverse::Tables::<Vec<u8>>::files(job);
    let mut tables = inverse::Tables::new(job, vec![vec![]; names.len()]).expect("memory");
    let mut summary = inverse::Summary::new(job);
    let mut curves = inverse::Curves::new(job, 4);
    let outcome = job.run(|sample| (&mut tables, &mut summary, &mut curves).add(sample), patient());
    let verdict = match outcome {
        Ok(verdict) => verdict,
        Err(error) => return finite::text("a reason", &error.to_string()),
    };
    for (name, table) in names.into_iter().zip(tables.finish().expect("memory")) {
        finite::table(name, &table);
    }
    finite::json("summary", &summary.json(job, &verdict), SUMMARY_EMPTY);
    let mut text = String::new();
    inverse::write_summary(&mut text, job, &summary, &verdict).expect("a string takes it");
    finite::text("summary", &text);
    for (name, figure) in curves.figures() {
        finite::picture(name, &figure.svg());
    }
}

/// Keys of the summary that may be `null`, because a value does not apply or has no limit, as other
/// keys state.
const SUMMARY_EMPTY: &[&str] = &[
    "interpolation",
    "efficiency",
    "friction_effect",
    "friction_contributions",
    "dissipated_part",
    "weighting",
    "friction_coupling",
    "friction_unique_up_to",
    "other_solutions",
    "friction_margin",
    "factor",
    "singular",
    "widest_interval",
    "drive_outer_low",
    "drive_outer_high",
    "interval_certified_within",
];

fn stopped(job: &Job<'_>) {
    let Ok(findings) = breakaway::evaluate(job, None) else { return };
    let mut text = String::new();
    breakaway::write_report(&mut text, job, &findings).expect("a string takes it");
    assert!(!text.contains("NaN"), "{text}");
    let _ = findings.json(job).to_string();
}

fn simulated(model: &ModelFile, motion: &Motion, load: &LoadCase) {
    let files = |_: &str| Err("none".to_owned());
    let control = |text: &str| model.parse_control(&Source::new("--controller", text), &files).ok();
    let actuators = model.mechanism.actuators().count();
    // Cases: only weight and loads; two controllers; prescribed motion of all actuators.
    for (control, prescribed, friction) in [
        (None, Vec::new(), true),
        (control("computed-torque+friction"), Vec::new(), true),
        (control("pd"), Vec::new(), false),
        (None, (0..actuators).collect(), true),
    ] {
        simulate(model, motion, load, control.as_ref(), prescribed, friction);
    }
}

fn simulate(
    model: &ModelFile,
    motion: &Motion,
    load: &LoadCase,
    control: Option<&Control>,
    prescribed: Vec<usize>,
    friction: bool,
) {
    let model = forward::arrange(model, friction, &[]);
    let span = if motion.duration > 0.0 { motion.duration.min(SPAN) } else { SPAN };
    let job = forward::Job {
        motion: Some(motion),
        control,
        prescribed,
        start: forward::Start::Moving,
        from: motion.start,
        until: motion.start + span,
        step: span / SAMPLES,
        friction,
        ..forward::Job::new(&model, ("load", load))
    };
    let summary = forward::Summary::new(&job);
    let curves = forward::Curves::new(&job, 4);
    let tables = forward::Tables::new(&job, [(); 6].map(|()| Vec::<u8>::new())).expect("memory");
    let mut recorder = forward::Recorder::new(&job, (summary, curves, tables));
    let begun = Instant::now();
    let outcome = job.run(|sample, _| recorder.add(sample), &|| begun.elapsed() > PATIENCE, None);
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => return finite::text("a reason", &error.to_string()),
    };
    let (summary, curves, tables) = recorder.sink;
    let files = tables.finish().expect("memory");
    for (name, file) in forward::Tables::<Vec<u8>>::FILES.into_iter().zip(&files) {
        finite::table(name, file);
    }
    let mut events = Vec::new();
    forward::write_events(&mut events, &summary, &outcome.events).expect("memory");
    let mut text = String::new();
    forward::write_summary(&mut text, &job, &summary, &outcome).expect("a string takes it");
    finite::text("summary", &text);
    const EMPTY: &[&str] = &[
        "controller",
        "ended_because",
        "error",
        "error_unit",
        "position_at_end",
        "rate_at_end",
        "work",
        "dissipated",
        "sticks",
        "stops",
        "error_relative",
        "motion",
        "coupling",
    ];
    finite::json("forward", &summary.json(&job, &outcome), EMPTY);
    for (name, figure) in curves.figures(&summary, &outcome.events) {
        finite::picture(name, &figure.svg());
    }
}
