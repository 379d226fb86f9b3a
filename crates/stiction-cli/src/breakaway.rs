//! `stiction breakaway`: static friction of a robot at rest.

use crate::arguments::Breakaway;
use crate::failure::Failure;
use crate::fold::folded;
use crate::print;
use crate::sources::{self, note_frictionless, warn};

pub(crate) fn run(options: &Breakaway) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Breakaway) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if !options.json {
        warn(robot.warnings());
        note_frictionless(&robot);
    }
    let mut request = robot.breakaway();
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(load) = &options.load {
        request = request.load(load)?;
    }
    if let Some(time) = options.at {
        request = request.at(time);
    }
    let rest = request.run()?;
    match options.json {
        true => print(&format!("{:#}\n", rest.to_json())),
        false => print(&folded(&rest.to_string())),
    }
}
