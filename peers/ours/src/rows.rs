//! Rows of coordinates in one call of the library, for the comparison with the same call from Python.

use crate::subject::Subject;
use std::hint::black_box;
use stiction::{Batch, FrictionMode, Outputs, Robot, Workers};

/// Inputs and expected efforts, from the file that `peers/python_level.py` writes.
pub(crate) struct Rows {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// Efforts without friction, and efforts with friction.
    efforts: [Vec<f64>; 2],
}

impl Rows {
    pub(crate) fn read(path: &str) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
        Self::parse(&text).ok_or_else(|| format!("{path} is not complete"))
    }

    /// Reads `rows N COLUMNS`, then for each row `q`, `v`, `a` and both kinds of efforts.
    fn parse(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace();
        if words.next()? != "rows" {
            return None;
        }
        let (rows, columns) =
            (words.next()?.parse::<usize>().ok()?, words.next()?.parse::<usize>().ok()?);
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        let numbers = numbers.filter(|n| n.len() == rows * 5 * columns && !n.is_empty())?;
        let part = |k: usize| {
            let of_row = |row: &[f64]| row[k * columns..(k + 1) * columns].to_vec();
            numbers.chunks_exact(5 * columns).flat_map(of_row).collect()
        };
        Some(Self { q: part(0), v: part(1), a: part(2), efforts: [part(3), part(4)] })
    }
}

/// Calls of the library for all rows, without friction and with friction, on one thread, with all
/// reactions.
///
/// # Errors
/// The robot cannot be compiled, or the number of rows does not fit it.
pub(crate) fn subjects<'a>(model: &str, rows: &'a Rows) -> Result<Vec<Subject<'a>>, String> {
    let robot = Robot::builtin(model).map_err(|error| error.to_string())?;
    let kinds = [
        ("rows_frictionless", FrictionMode::Off, &rows.efforts[0]),
        ("rows_friction", FrictionMode::Converged, &rows.efforts[1]),
    ];
    let subject = |(name, friction, expected): (_, _, &Vec<f64>)| {
        let states = robot.states().friction(friction).compile();
        let states = states.map_err(|error| error.to_string())?;
        let compute = move || {
            let batch = Batch { q: &rows.q, v: &rows.v, a: &rows.a };
            let outputs = Outputs { reactions: true, ..Outputs::default() };
            states.inverse_dynamics(batch, outputs, &Workers::default())
        };
        let results = compute().map_err(|error| error.to_string())?;
        let is_equal =
            results.efforts.iter().map(|x| x.to_bits()).eq(expected.iter().map(|x| x.to_bits()));
        let batch = move |_| black_box(compute()).map_or(1, |results| results.status.len());
        let difference = if is_equal { 0.0 } else { f64::INFINITY };
        Ok(Subject { name, difference, batch: Box::new(batch) })
    };
    kinds.into_iter().map(subject).collect()
}
