//! Behaviour of the code at rest, at reversals and for impossible inputs.

use super::compiler::{Code, SANITIZERS, STRICT};
use super::{labels, variant};
use crate::common::gallery_loop;
use stiction_program::emit::{Language, Precision};
use stiction_program::{Feedforward, Tunable};

/// Directions of friction at rest and return codes are as documented, and results are finite for a
/// million unusual inputs.
#[test]
fn codes_and_rest_are_as_documented() {
    let robot = gallery_loop("zhang2018-regular").unwrap();
    let tunables = Tunable::frictions(robot.solver.parameters());
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
    for own_math in [false, true] {
        let options = variant("behaviour", Precision::Double, own_math);
        let files =
            program.files(Language::C, &labels("behaviour", &robot), &options, &[]).unwrap();
        let folder = format!("behaviour-{own_math}");
        let Some(code) = Code::new(&folder, &options.name, &files) else { return };
        let starts: Vec<String> = program.home().iter().map(|x| format!("{x:?}")).collect();
        let main = include_str!("behaviour.c").replace("HOME", &starts.join(", "));
        code.run_with("behaviour_main", &main, &[&STRICT[..], &["-std=c99"], &SANITIZERS].concat());
    }
}
