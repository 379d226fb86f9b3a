//! Functional mock-up units: description and code.

use super::{gallery_loop, labels, variant};
use crate::emit::compiler::{Code, SANITIZERS, STRICT};
use std::fmt::Write;
use stiction_program::emit::fmu::Fmi;
use stiction_program::emit::{Precision, SourceFile, TestVector};
use stiction_program::{Feedforward, Tunable};

fn text<'a>(files: &'a [SourceFile], name: &str) -> &'a str {
    &files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("{name}")).text
}

/// Value of an XML attribute.
fn attribute<'a>(xml: &'a str, name: &str) -> &'a str {
    let at = xml.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
    xml[at..].split('"').next().unwrap()
}

/// The code of both FMI versions reproduces the solver's forces in 100 interleaved instances, saves
/// and restores states, and rejects invalid calls; the description matches the code.
#[test]
fn fmus_reproduce_the_solver() {
    let robot = gallery_loop("five-bar").unwrap();
    let tunables = Tunable::frictions(robot.solver.parameters());
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
    let vectors = TestVector::random(&robot.solver, &robot.signal, 20, 7);
    let mut rows = String::new();
    for TestVector { positions, rates, accelerations, efforts } in &vectors {
        let all = [&positions[..], rates, accelerations, efforts].concat();
        let _ = writeln!(rows, "    {{ {all:?} }},");
    }
    let rows = rows.replace(['[', ']'], "");
    let options = variant("five-bar", Precision::Double, false);
    for (fmi, number) in [(Fmi::Two, "2"), (Fmi::Three, "3")] {
        let files = program.fmu(fmi, &labels("five-bar", &robot), &options).unwrap();
        let xml = text(&files, "modelDescription.xml");
        assert_eq!(attribute(xml, "fmiVersion"), format!("{number}.0"));
        assert_eq!(attribute(xml, "modelIdentifier"), "five_bar");
        let token = attribute(xml, if number == "2" { "guid" } else { "instantiationToken" });
        let adapter = text(&files, &format!("sources/fmi{number}.c"));
        assert!(adapter.contains(&format!("\"{token}\"")), "{token}");
        let wanted = [
            "name=\"left_motor.position\" valueReference=\"1\"",
            "name=\"right_motor.acceleration\" valueReference=\"6\"",
            "name=\"left_motor.effort\" valueReference=\"7\"",
            "unit=\"N.m\"",
            "<Unit name=\"rad/s2\"><BaseUnit rad=\"1\" s=\"-2\"/></Unit>",
            "name=\"left_elbow.mu\"",
        ];
        for wanted in wanted {
            assert!(xml.contains(wanted), "{wanted}");
        }
        assert_eq!(program.fmu(fmi, &labels("five-bar", &robot), &options).unwrap(), files);
        let bare: Vec<SourceFile> = files
            .iter()
            .filter_map(|file| {
                let name = file.name.strip_prefix("sources/")?.to_owned();
                Some(SourceFile { name, text: file.text.clone() })
            })
            .collect();
        let Some(code) = Code::new(&format!("fmu{number}"), "five_bar", &bare) else { return };
        let main = include_str!("fmu.c")
            .replace("DRIVER_SOURCE", &format!("fmi{number}.c"))
            .replace("VECTORS_HERE", &rows)
            .replace("TOKEN", token)
            .replace("VERSION", number);
        let said =
            code.run_with("driver", &main, &[&STRICT[..], &["-std=c99"], &SANITIZERS].concat());
        let expected = format!("{} rows, 100 instances, 0 complaints", vectors.len());
        assert!(vectors.len() > 10 && said.contains(&expected), "{said}");
    }
}

/// Names of a model cannot break the description.
#[test]
fn hostile_names_stay_inside_the_description() {
    let robot = gallery_loop("five-bar").unwrap();
    let program = Feedforward::record(&robot.solver, &robot.signal, &[Tunable::Mu(0)]).unwrap();
    let mut labels = labels("\"/><x>&\n\u{1}", &robot);
    for (name, _) in labels.coordinates.iter_mut().chain(&mut labels.actuators) {
        *name = "\"/></ModelVariables>&\n\u{1}<!--".to_owned();
    }
    let options = variant("five-bar", Precision::Double, false);
    let files = program.fmu(Fmi::Three, &labels, &options).unwrap();
    let xml = text(&files, "modelDescription.xml");
    assert_eq!(xml.matches("</ModelVariables>").count(), 1);
    assert!(!xml.contains("<!--") && !xml.contains('\u{1}') && !xml.contains("<x>"));
    // Two actuators with the same name have variables with different names.
    let names: Vec<&str> =
        xml.lines().filter(|l| l.contains(".effort")).map(|l| attribute(l, "name")).collect();
    assert!(names.len() == 2 && names[0] != names[1], "{names:?}");
}
