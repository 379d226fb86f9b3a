//! `stiction equilibrium` and `stiction linearize`: static equilibria, and linear models about an
//! operating point.

use crate::answer;
use crate::arguments::{Equilibrium, Linearize, Switch};
use crate::failure::Failure;
use crate::fold::folded;
use crate::outputs::Outputs;
use crate::print;
use crate::sources::{self, note_friction, warn};
use crate::written::note_files;
use stiction::FrictionMode;

pub(crate) fn run_equilibrium(options: &Equilibrium) -> Result<(), Failure> {
    equilibrium(options).map_err(|failure| failure.into_json(options.json))
}

fn equilibrium(options: &Equilibrium) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if !options.json {
        warn(robot.warnings());
    }
    let mut request = robot.equilibrium()?;
    for joint in &options.hold {
        request = request.hold(joint)?;
    }
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(load) = &options.load {
        request = request.load(load)?;
    }
    if let Some(drives) = &options.drives {
        request = request.drives(drives)?;
    }
    if let Some(start) = &options.from {
        request = request.from(start)?;
    }
    if options.nearest {
        request = request.nearest();
    }
    let found = request.run()?;
    match options.json {
        true => answer::give(&found.to_json()),
        false => print(&folded(&found.to_string()))?,
    }
    Ok(())
}

pub(crate) fn run_linearize(options: &Linearize) -> Result<(), Failure> {
    linearize(options).map_err(|failure| failure.into_json(options.json))
}

fn linearize(options: &Linearize) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if !options.json {
        warn(robot.warnings());
        let is_on = options.friction.map(|friction| friction == Switch::On);
        let default = robot.model().default_friction != Some(FrictionMode::Off);
        note_friction(&robot, is_on.unwrap_or(default));
    }
    let mut request = robot.linearize()?;
    if let Some(friction) = options.friction {
        request = request.friction(friction == Switch::On);
    }
    for joint in &options.hold {
        request = request.hold(joint)?;
    }
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(time) = options.at {
        request = request.at(time)?;
    }
    if let Some(load) = &options.load {
        request = request.load(load)?;
    }
    if let Some(drives) = &options.drives {
        request = request.drives(drives)?;
    }
    if let Some(start) = &options.from {
        request = request.from(start)?;
    }
    // Reject an unwritable folder before the computation.
    let mut outputs =
        options.output.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    let model = request.run()?;
    let json = model.json();
    match options.json {
        true => answer::give(&json),
        false => print(&folded(&model.to_string()))?,
    }
    let Some(mut outputs) = outputs.take() else { return Ok(()) };
    for (name, table) in model.tables() {
        outputs.write(name, table.as_bytes())?;
    }
    outputs.write("linearize.json", format!("{json:#}\n").as_bytes())?;
    let files = outputs.complete(&[])?;
    if !options.json {
        note_files(&files, true);
    }
    Ok(())
}
