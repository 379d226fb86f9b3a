//! Combinations of the chosen parameters that measured efforts determine.

use super::objective::Objective;
use nalgebra::{DMatrix, DVector, RowDVector};
use stiction_core::random::Random;
use stiction_identify::{BaseParameters, Parameter};

/// Computes the combinations of parameters that the efforts determine. The regressor is evaluated
/// at the positions of the motion, with random rates and accelerations.
pub(super) fn structure(
    objective: &mut Objective,
    x: &DVector<f64>,
    parameters: &[Parameter],
    seed: u64,
) -> BaseParameters {
    let grid = objective.grid.clone();
    let columns = objective.columns.clone();
    let mut random = Random::new(seed ^ 0x57);
    let mut greatest = [0.0_f64; 2];
    for k in 0..grid.len() {
        let [_, v, a] = grid.motion(k, x);
        for (size, values) in greatest.iter_mut().zip([v, a]) {
            *size = values.iter().fold(*size, |max, x| max.max(x.abs()));
        }
    }
    let mut rows: Vec<RowDVector<f64>> = Vec::new();
    // Two passes over the time grid yield enough rows for every parameter of a robot with few
    // actuators.
    for _ in 0..2 {
        let _ = objective.read(&grid, x, |probe, k, reading| {
            let [q, ..] = grid.motion(k, x);
            let mut some = |size: f64| q.iter().map(|_| size * random.number()).collect::<Vec<_>>();
            let (v, a) = (some(greatest[0]), some(greatest[1]));
            let Some(reading) = probe.at([&q, &v, &a], Some(reading.index)) else { return };
            for row in reading.rows.row_iter() {
                rows.push(RowDVector::from_iterator(
                    columns.len(),
                    columns.iter().map(|&(k, _)| row[k]),
                ));
            }
        });
    }
    match rows.is_empty() {
        true => BaseParameters::of(&DMatrix::zeros(0, parameters.len()), parameters),
        false => BaseParameters::of(&DMatrix::from_rows(&rows), parameters),
    }
}
