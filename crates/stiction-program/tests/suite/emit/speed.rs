//! Execution time, code size and stack usage of the source code.

use super::compiler::Code;
use super::labels;
use crate::common::gallery_loop;
use std::time::Instant;
use stiction_program::emit::{Language, SourceOptions};
use stiction_program::{Feedforward, Tunable};

/// Largest execution time of the source code with the best options of the compiler, relative to the
/// machine code of this crate: without `info`, which is the same work, and with `info`, which adds
/// the singularity index.
const SLOWEST: [f64; 2] = [1.5, 1.6];
/// Largest size of code and constants of `3rps` with `-O2`, bytes.
const LARGEST: u32 = 60_000;

/// Prints the time of a call along a smooth motion at 1 kHz, for the program on this processor and
/// for the C code, and the size and stack usage of the C code; checks the values of `3rps`.
#[test]
#[ignore = "measures time"]
fn speed_and_size_are_bounded() {
    for name in ["3rps", "zhang2018-regular", "five-bar", "gough"] {
        let robot = gallery_loop(name).unwrap();
        let tunables = Tunable::frictions(robot.solver.parameters());
        let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
        let options = SourceOptions::new(name);
        let files = program.files(Language::C, &labels(name, &robot), &options, &[]).unwrap();
        let Some(code) = Code::new(&format!("speed-{name}"), &options.name, &files) else { return };
        let home = program.home().to_vec();
        let starts: Vec<String> = home.iter().map(|x| format!("{x:?}")).collect();
        let text = include_str!("speed.c").replace("HOME", &starts.join(", "));
        let (here, sum) = machine_code(&program);
        println!("{name}: {:?}; machine code here: {here:.0} ns", program.operations());
        for flags in [&["-O2"][..], &["-O3", "-march=native"]] {
            // The machine may be busy: each takes the best of several runs, in alternation with the
            // machine code.
            let (mut best, mut least) = ([f64::INFINITY; 2], here);
            for _ in 0..5 {
                for (best, details) in best.iter_mut().zip(["-DDETAILS=0", "-DDETAILS=&info"]) {
                    let said = code.run_with("speed", &text, &[flags, &[details]].concat());
                    let numbers: Vec<f64> =
                        said.split(' ').filter_map(|word| word.trim().parse().ok()).collect();
                    let [time, _, _, found] = numbers[..] else { panic!("{said}") };
                    assert!(
                        (found - sum).abs() <= 1e-9 * sum.abs(),
                        "the same results: {found} {sum}"
                    );
                    *best = best.min(time);
                }
                least = least.min(machine_code(&program).0);
            }
            let (size, stack) = code.size(flags);
            let ratios = best.map(|time| time / least);
            println!(
                "  {flags:?}: {:.0} ns, {:.2} times the machine code, with the singularity index {:.0} ns, {:.2} times; \
                 .text and .rodata {size} bytes, stack {stack} bytes in all functions",
                best[0], ratios[0], best[1], ratios[1]
            );
            if name == "3rps" {
                let is_fast = ratios.iter().zip(SLOWEST).all(|(ratio, most)| *ratio <= most);
                assert!(flags.len() < 2 || is_fast, "{ratios:?}");
                assert!(flags.len() > 1 || size <= LARGEST, "{size}");
            }
        }
    }
}

/// Shortest time of a call, ns, and the sum of an effort over all calls, as in `speed.c`.
fn machine_code(program: &Feedforward) -> (f64, f64) {
    let (rounds, calls) = (21, 2000);
    let (mut best, mut sum) = (f64::INFINITY, 0.0);
    let home = program.home();
    for _ in 0..rounds {
        let mut memory = program.memory();
        let begun = Instant::now();
        for k in 0..calls {
            let at = |f: fn(f64) -> f64| -> Vec<f64> {
                let time = |i: usize| 0.001 * f64::from(k) * (1.0 + 0.2 * i as f64);
                (0..home.len()).map(|i| 0.02 * f(time(i))).collect()
            };
            let q: Vec<f64> = at(f64::sin).iter().zip(home).map(|(x, h)| h + x).collect();
            let a: Vec<f64> = at(f64::sin).iter().map(|x| -x).collect();
            let outcome = program.run(&mut memory, &q, &at(f64::cos), &a);
            assert_eq!(outcome.shortfall, None);
            sum += program.drive(&memory, 0);
        }
        best = best.min(begun.elapsed().as_secs_f64() * 1e9 / f64::from(calls));
    }
    (best, sum)
}
