//! Behaviour of the code at rest, at reversals and for impossible inputs.

use super::compiler::{Code, STRICT};
use super::labels;
use crate::common::gallery_loop;
use stiction_program::emit::{Language, SourceOptions};
use stiction_program::{Feedforward, Tunable};

/// Directions of friction at rest, return codes, and finite results for a million odd inputs.
#[test]
fn codes_and_rest_are_as_documented() {
    let robot = gallery_loop("zhang2018-regular").unwrap();
    let tunables = Tunable::frictions(robot.solver.parameters());
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
    let options = SourceOptions::new("behaviour");
    let files = program.files(Language::C, &labels("behaviour", &robot), &options, &[]).unwrap();
    let Some(code) = Code::new("behaviour", &options.name, &files) else { return };
    let starts: Vec<String> = program.home().iter().map(|x| format!("{x:?}")).collect();
    let main = include_str!("behaviour.c").replace("HOME", &starts.join(", "));
    let sanitizers = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    code.run_with("behaviour_main", &main, &[&STRICT[..], &["-std=c99"], &sanitizers].concat());
}
