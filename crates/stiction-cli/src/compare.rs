//! `stiction compare`: two models, or a model and a variant of it, along the same motion.

use crate::answer;
use crate::arguments::{Compare, Formats, Model};
use crate::failure::Failure;
use crate::fold::folded;
use crate::inverse::{Choice, along, listen_for_interrupt};
use crate::outputs::Outputs;
use crate::print;
use crate::report;
use crate::sources::{self, warn};
use crate::written::note_folder;
use serde_json::json;
use stiction::Robot;
use stiction_run::comparison::{Comparison, overlay};
use stiction_run::heading;

pub(crate) fn run(options: &Compare) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

/// Reads the two models.
fn models(options: &Compare) -> Result<[Model; 2], Failure> {
    if options.second.is_none() && options.set_a == options.set_b {
        return Err(Failure::input(
            "both sides are the same model: there is no difference to show",
        )
        .help("give a second model, or change one side with --set-b KEY=VALUE"));
    }
    let is_read_twice = options.second.as_ref().is_none_or(|second| *second == options.first);
    if options.first == "-" && is_read_twice {
        return Err(Failure::input("standard input can be read only once")
            .help("save the model in a file, and give the file instead of `-`"));
    }
    let second = options.second.as_ref().unwrap_or(&options.first);
    let model = |name: &std::ffi::OsString, own: &[String]| Model {
        name: Some(name.clone()),
        set: options.set.iter().chain(own).cloned().collect(),
        reading: options.reading.clone(),
    };
    Ok([model(&options.first, &options.set_a), model(second, &options.set_b)])
}

fn execute(options: &Compare) -> Result<(), Failure> {
    let models = models(options)?;
    // Failures say which of the two models they concern.
    let of_side =
        |side: usize| move |failure: Failure| failure.in_run(["model A", "model B"][side]);
    let robots = [
        sources::filtered_robot(&models[0], &options.filter).map_err(of_side(0))?,
        sources::filtered_robot(&models[1], &options.filter).map_err(of_side(1))?,
    ];
    let interrupted = listen_for_interrupt();
    let choice = Choice {
        friction: options.friction,
        step: options.sampling.step,
        threads: options.threads.threads,
        friction_margin: options.friction_margin,
        filter: options.filter,
        formats: Formats { csv: true, npz: false, mcap: false },
        report: options.report,
        runs: 2,
    };
    let (motion, load) = (options.motion.as_deref(), options.load.as_deref());
    let mut requests = Vec::new();
    for (side, robot) in robots.iter().enumerate() {
        warn(robot.warnings());
        requests.push(choice.request(robot, motion, load).map_err(of_side(side))?);
    }
    let folder = options.report.folder(options.output.as_deref())?;
    let folder = folder.as_deref();
    let inputs = robots.iter().flat_map(Robot::files_read).collect();
    let outputs = folder.map(|dir| Outputs::new(dir, inputs)).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let (mut runs, mut compared) = (Vec::new(), Vec::new());
    let (mut curves, mut reels) = (Vec::new(), Vec::new());
    let mut files = Vec::new();
    let (mut text, mut about) = (String::new(), String::new());
    for (index, (robot, request)) in robots.iter().zip(&requests).enumerate() {
        let side = ["A", "B"][index];
        let folder = folder.map(|dir| dir.join(side));
        let run = along(robot, request, &choice, folder.as_deref(), &interrupted, |_| Ok(()))
            .map_err(of_side(index))?;
        let job = request.job()?;
        let heading = heading(robot.name(), robot.title());
        let conditions = format!(
            "motion {}, load {}, friction {}",
            job.motion_name,
            job.load_name,
            run.json["options"]["friction"].as_str().unwrap_or_default(),
        );
        text += &format!("{side}: {heading}\n   {conditions}\n");
        about += &format!("{side}: {heading}; {conditions}\n");
        for caution in run.json["cautions"].as_array().into_iter().flatten() {
            text += &format!("   CAUTION: {}\n", caution.as_str().unwrap_or_default());
        }
        files.extend(run.files);
        runs.push(run.json);
        compared.push((side.to_owned(), run.compared));
        curves.push((side.to_owned(), run.efforts));
        reels.extend(run.reel.map(|reel| (side.to_owned(), reel)));
    }
    let comparison = Comparison::of_models(compared);
    let json = json!({ "comparison": comparison.json(), "A": runs[0], "B": runs[1] });
    if options.json {
        answer::give(&json);
    } else {
        let mut table = String::new();
        // Writing to a string cannot fail.
        let _ = comparison.write_differences(&mut table);
        let mut cautions = String::new();
        let _ = comparison.write_cautions(&mut cautions);
        let space = if cautions.is_empty() { "" } else { "\n" };
        print(&format!("{}\n{table}{space}{}", folded(&text), folded(&cautions)))?;
        if !comparison.has_common_effort() {
            note!(
                "\nnote: no actuator has the same name and unit in both models, so no efforts are \
                compared"
            );
        }
    }
    if let Some(mut outputs) = outputs {
        outputs.write("compare.json", format!("{json:#}\n").as_bytes())?;
        outputs.write("compare.csv", &comparison.csv())?;
        let names = [robots[0].name(), robots[1].name()];
        let title = match names[0] == names[1] {
            true => format!("{}, two variants", names[0]),
            false => format!("A {}, B {}", names[0], names[1]),
        };
        let figure = overlay(format!("Actuator efforts: {title}"), curves);
        if options.report.is_on() {
            let command = report::command_line();
            let page = comparison.report((&title, &about), &figure, reels, Some(&command));
            outputs.write(report::FILE, page.as_bytes())?;
        }
        outputs.write_figures(vec![("drives", figure)])?;
        files.extend(outputs.complete(&["drives.png", report::FILE])?);
    }
    if !options.json {
        note_folder(folder, &files);
    }
    options.report.show(folder);
    Ok(())
}
