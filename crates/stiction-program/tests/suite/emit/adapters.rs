//! The source code in other environments and on other processors.

use super::compiler::{Code, STRICT, is_installed};
use super::{labels, variant};
use crate::common::gallery_loop;
use stiction_program::emit::{Adapters, Functions, Language, Precision, SourceOptions, TestVector};
use stiction_program::{Feedforward, Tunable};

const ALL: Adapters = Adapters { ctypes: true, linuxcnc: true, cortex_m7: true };

/// Code with all adapters, functions, and kinds of parameters.
fn complete(name: &str, precision: Precision) -> Option<Code> {
    let robot = gallery_loop(name).unwrap();
    let last = robot.solver.mechanism().bodies().len() - 1;
    let body = stiction_core::mechanism::BodyId(last);
    let mut tunables = Tunable::frictions(robot.solver.parameters());
    tunables.extend([Tunable::Payload(body), Tunable::Wrench(body)]);
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables)
        .and_then(|program| program.with_derivatives(&robot.solver, &robot.signal))
        .unwrap();
    let vectors = TestVector::random(&robot.solver, &robot.signal, 100, 7);
    assert!(vectors.len() > 50);
    let functions =
        Functions { kinematics: true, reactions: true, derivatives: true, accelerations: true };
    let options = SourceOptions { functions, adapters: ALL, ..variant(name, precision, true) };
    let files = program.files(Language::C, &labels(name, &robot), &options, &vectors).unwrap();
    assert_eq!(
        program.files(Language::C, &labels(name, &robot), &options, &vectors).unwrap(),
        files
    );
    Code::new(&format!("adapters-{name}-{precision:?}"), &options.name, &files)
}

/// Python calls the code through ctypes and reproduces the test vectors.
#[test]
fn python_reproduces_the_solver() {
    let Some(code) = complete("five-bar", Precision::Double) else { return };
    if is_installed("python3") && is_installed("make") {
        let said = code.make("test-python");
        assert!(said.contains(" 0 failures"), "{said}");
    }
}

/// The Python adapter rejects a library of another model, with other structures, or without the
/// function that identifies the library.
#[test]
fn python_refuses_another_library() {
    let Some(code) = complete("slider-crank", Precision::Double) else { return };
    if !(is_installed("python3") && is_installed("make")) {
        return;
    }
    let begin = "import slider_crank\n\
                 try:\n    slider_crank.Robot([0.1])\n    print('accepted')\n\
                 except ValueError as error:\n    print(error)\n";
    code.make("library");
    assert_eq!(code.python(begin), "accepted\n");
    let read = |file: &str| String::from_utf8(code.read(file)).unwrap();
    let files = ["slider_crank.h", "slider_crank.c"].map(|file| (file, read(file)));
    let line = |part: &str| files[0].1.lines().find(|line| line.contains(part)).unwrap();
    let fingerprint = line("FINGERPRINT_HIGH 0x");
    let other = fingerprint.split("0x").next().unwrap().to_owned() + "0x1u";
    let longer = ["    unsigned ready;", "    int rest;", "    int fallback;"];
    let longer = longer.map(|field| (0, field, format!("{field}\n    int more[2];")));
    let renamed = "unsigned slider_crank_other(".to_owned();
    let changes = [(0, fingerprint, other), (1, "unsigned slider_crank_identity(", renamed)];
    for (file, before, after) in changes.into_iter().chain(longer) {
        let (name, text) = &files[file];
        let changed = text.replacen(before, &after, 1);
        assert_ne!(&changed, text, "{before}");
        code.write(name, changed.as_bytes());
        code.make("library");
        let said = code.python(begin);
        assert!(said.contains("run `make library`"), "{after}: {said}");
        code.write(name, text.as_bytes());
    }
}

/// The self-test passes on a bare Cortex-M7 and on AArch64, both in emulators.
#[test]
#[ignore = "needs compilers and emulators for other processors"]
fn other_processors_reproduce_the_solver() {
    for name in ["3rps", "five-bar"] {
        for precision in [Precision::Double, Precision::Float] {
            let Some(code) = complete(name, precision) else { return };
            if is_installed("arm-none-eabi-gcc") && is_installed("qemu-system-arm") {
                let said = code.make("test-cortex-m7");
                assert!(said.contains(" 0 failures") && !said.contains("warning"), "{said}");
                println!("{name} {precision:?} on a Cortex-M7: {}", said.lines().last().unwrap());
            }
            if is_installed("aarch64-linux-gnu-gcc") && is_installed("qemu-aarch64") {
                let flags = [&STRICT[..], &["-std=c99", "-O2", "-static"]].concat();
                let said = code.selftest_by("aarch64-linux-gnu-gcc", "qemu-aarch64", &flags);
                println!("{name} {precision:?} on AArch64: {said}");
            }
        }
    }
}

/// LinuxCNC's compiler builds a component from the code.
#[test]
#[ignore = "needs LinuxCNC"]
fn linuxcnc_compiles_the_component() {
    for name in ["3rps", "five-bar"] {
        let Some(code) = complete(name, Precision::Double) else { return };
        if is_installed("halcompile") {
            let said = code.make("linuxcnc");
            // A limit for kernel modules; threads of LinuxCNC in user space have a stack of their own size.
            let is_known = |line: &str| line.contains("-Wframe-larger-than=");
            let warnings = said.lines().filter(|line| line.contains("warning"));
            assert!({ warnings }.all(is_known) && !said.contains("error"), "{said}");
        }
    }
}

/// Names of the model enter the adapters only as harmless text.
#[test]
fn hostile_names_do_no_harm_in_adapters() {
    let robot = gallery_loop("five-bar").unwrap();
    let program = Feedforward::record(&robot.solver, &robot.signal, &[Tunable::Mu(0)]).unwrap();
    let hostile = "\"\"\"\nimport os #*/ ;;\n\\@NAME@ $(shell x)";
    let mut labels = labels(hostile, &robot);
    for (name, _) in labels.coordinates.iter_mut().chain(&mut labels.actuators) {
        *name = hostile.to_owned();
    }
    for names in [&mut labels.joints, &mut labels.interfaces, &mut labels.bodies] {
        names.fill(hostile.to_owned());
    }
    let options = SourceOptions { adapters: ALL, ..SourceOptions::new("arm") };
    let files = program.files(Language::C, &labels, &options, &[]).unwrap();
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    for name in ["arm.py", "arm_hal.comp", "cortex_m7.c", "cortex_m7.ld", "Makefile"] {
        assert!(names.contains(&name), "{names:?}");
    }
    for file in &files {
        assert!(file.text.is_ascii(), "{}", file.name);
        for harm in ["\"\"\"\nimport", "import os #", "$(shell", "*/ ;;", "\\@"] {
            assert!(!file.text.contains(harm), "{}: {harm}", file.name);
        }
    }
}
