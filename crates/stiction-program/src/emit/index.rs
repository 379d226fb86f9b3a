//! Values that are inserted into the generated source code of the singularity index.

use super::{Precision, SourceOptions, answers};
use crate::feedforward::{Feedforward, INDEX_PASSES, Term};

/// Convergence limit of the inverse iteration, in double and in single precision: largest squared
/// sine of the angle between a vector and its next iterate.
const ALIGNED: [f64; 2] = [1e-8, 1e-6];
/// Convergence limit of the inverse iteration with two vectors, in double and in single precision:
/// largest relative decrease of the squared singularity index that the second vector may still
/// cause.
const LOWERED: [f64; 2] = [1e-7, 1e-5];
/// Limit, in double and in single precision, up to which the two iterated vectors count as
/// parallel: squared norm of the component of the second vector that is perpendicular to the first
/// vector, divided by the squared norm of the second vector. The limit is a multiple of rounding
/// errors. Near singular positions the vectors become parallel, and the first converges without the
/// second.
const PARALLEL: [f64; 2] = [1e-8, 1e-3];
/// Largest singularity index at which a position counts as singular, in double and in single
/// precision.
const LEAST_INDEX: [f64; 2] = [1e-10, 1e-5];
/// Smallest determinant, relative to that at the home position, at which a position counts as
/// regular without computing the singularity index.
const SMALL_DETERMINANT: f64 = 1e-3;

/// Returns the names and values that fill the templates of the singularity index. `[open, close]`
/// are the brackets of nested lists in the programming language.
pub(super) fn values(
    program: &Feedforward,
    options: &SourceOptions,
    number: &dyn Fn(f64) -> String,
    [open, close]: [&str; 2],
) -> Vec<(&'static str, String)> {
    let pick = |[double, float]: [f64; 2]| {
        number(if options.precision == Precision::Double { double } else { float })
    };
    let index = &program.index;
    let list = |numbers: &mut dyn Iterator<Item = usize>| {
        let numbers: Vec<String> = numbers.map(|number| number.to_string()).collect();
        if numbers.is_empty() { "0".to_owned() } else { numbers.join(", ") }
    };
    let on: Vec<String> = index
        .terms
        .iter()
        .map(|Term { on: [a, b], .. }| format!("{open}{a}, {b}{close}"))
        .collect();
    let row = |term: usize| {
        let signs = index.signs.iter().map(|signs| number(f64::from(signs[term])));
        let signs: Vec<String> = signs.collect();
        let signs = if signs.is_empty() { number(0.0) } else { signs.join(", ") };
        format!("    {open}{signs}{close},\n")
    };
    let mut signs: Vec<String> = (0..index.terms.len()).map(row).collect();
    if signs.is_empty() {
        let none = vec![number(0.0); index.motions.len().max(1)].join(", ");
        signs.push(format!("    {open}{none}{close},\n"));
    }
    let sizes = program.sizes();
    let first_place = sizes.unknowns + answers(sizes, options.functions) + 2;
    vec![
        ("INDEX_PASSES", INDEX_PASSES.to_string()),
        ("ALIGNED", pick(ALIGNED)),
        ("LOWERED", pick(LOWERED)),
        ("PARALLEL", pick(PARALLEL)),
        ("LEAST_INDEX", pick(LEAST_INDEX)),
        ("SMALL_DETERMINANT", number(SMALL_DETERMINANT)),
        ("LENGTH", format!("{:?}", program.length())),
        ("MOTIONS", index.motions.len().to_string()),
        ("COLUMNS", index.columns.to_string()),
        ("TERMS", index.terms.len().to_string()),
        ("REDUNDANT", index.redundant().to_string()),
        ("SPINS", index.spins.to_string()),
        ("FIRST_PLACE", first_place.to_string()),
        ("PARENT", list(&mut index.parents.iter().copied())),
        ("MOVES", list(&mut index.motions.iter().copied())),
        ("COLUMN_OF", list(&mut index.terms.iter().map(|term| term.column))),
        ("ON", if on.is_empty() { format!("{open}0, 0{close}") } else { on.join(", ") }),
        ("SIGN", signs.concat()),
    ]
}
