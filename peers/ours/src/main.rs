//! Stiction's side of `cargo xtask peers`: serves batches of evaluations like the harnesses of the
//! other engines, by the protocol in `peers/harness.hpp`.

mod expected;
mod kernels;
mod programs;
mod robot;
mod rows;
mod subject;

use expected::Expected;
use robot::Robot;
use rows::Rows;
use std::io::{self, BufRead, Write};
use std::process::ExitCode;
use std::time::Instant;
use subject::Subject;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        [model] => run(model, None),
        [model, "--rows", file] => run_rows(model, file),
        [model, file] => run(model, Some(file)),
        _ => {
            eprintln!("usage: stiction-peers MODEL [MODEL.ours.txt | --rows FILE]");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("{what}");
            ExitCode::FAILURE
        }
    }
}

/// Serves evaluations of a model. Without a file of expected forces, those of the general solver at
/// instants of the default motion are used.
fn run(model: &str, file: Option<&str>) -> Result<(), String> {
    let expected = match file {
        Some(file) => Expected::read(file)?,
        None => robot::solved(model)?,
    };
    let robot = Robot::new(model, &expected)?;
    let mut subjects = programs::subjects(&robot, &expected);
    subjects.extend(kernels::subjects(&robot, &expected));
    serve(&mut subjects).map_err(|error| error.to_string())?
}

/// Serves calls for all rows of a file.
fn run_rows(model: &str, file: &str) -> Result<(), String> {
    let rows = Rows::read(file)?;
    serve(&mut rows::subjects(model, &rows)?).map_err(|error| error.to_string())?
}

/// Prints the available subjects, then answers each line `NAME COUNT` with the nanoseconds per
/// state.
fn serve(subjects: &mut [Subject<'_>]) -> io::Result<Result<(), String>> {
    let mut out = io::stdout().lock();
    for subject in subjects.iter() {
        writeln!(out, "subject {} {:.3e}", subject.name, subject.difference)?;
    }
    writeln!(out, "ready")?;
    out.flush()?;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let request = line.split_once(' ').and_then(|(name, count)| {
            let subject = subjects.iter_mut().find(|subject| subject.name == name)?;
            Some((subject, count.parse::<usize>().ok().filter(|&count| count > 0)?))
        });
        let Some((subject, count)) = request else {
            return Ok(Err(format!("no such request: {line}")));
        };
        let begun = Instant::now();
        let states = (subject.batch)(count);
        let taken = begun.elapsed();
        writeln!(out, "{:.3}", taken.as_secs_f64() * 1e9 / states as f64)?;
        out.flush()?;
    }
    Ok(Ok(()))
}
