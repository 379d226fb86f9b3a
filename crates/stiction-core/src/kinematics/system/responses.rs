//! Motion of the spanning tree per unit of a prescribed coordinate or passive spin.

use super::Kinematics;
use crate::kinematics::model::KinematicModel;
use crate::scalar::{Lanes, Scalar};

/// Number of prescribed coordinates whose responses are computed together.
const WIDTH: usize = 4;

impl<T: Scalar> Kinematics<T> {
    /// Computes the rates of the spanning tree for a unit rate of one prescribed coordinate and
    /// zero rates of all other prescribed coordinates and spins. Call [`Self::differentiate`]
    /// before.
    pub(crate) fn response_to_coordinate(
        &mut self,
        model: &KinematicModel,
        coordinate: usize,
        rates: &mut [T],
    ) {
        debug_assert!(coordinate < model.constraints.coordinates().len());
        self.right.fill(T::zero());
        self.right[self.closures + coordinate] = T::one();
        self.solve(&model.constraints, &model.rates, rates);
    }

    /// Computes the accelerations of the spanning tree for a unit acceleration of one passive spin,
    /// with zero accelerations of all other spins and prescribed coordinates and without velocity
    /// terms. Call [`Self::differentiate`] before.
    pub(crate) fn response_to_spin(
        &mut self,
        model: &KinematicModel,
        spin: usize,
        accelerations: &mut [T],
    ) {
        let constraints = &model.constraints;
        self.right.fill(T::zero());
        self.right[constraints.rows.len() - constraints.spins.len() + spin] = T::one();
        self.solve(constraints, &model.rates, accelerations);
    }
}

impl Kinematics<f64> {
    /// Computes the rates of the spanning tree for a unit rate of each prescribed coordinate, with
    /// zero rates of all other prescribed coordinates and spins. Calls `take` with the index of
    /// each coordinate and the rates. Call [`Self::differentiate`] before.
    pub(crate) fn responses_to_coordinates(
        &self,
        model: &KinematicModel,
        mut take: impl FnMut(usize, &[f64]),
    ) {
        let count = model.constraints.coordinates().len();
        let mut right = vec![Lanes::<f64, WIDTH>::zero(); self.right.len()];
        let mut solution = vec![Lanes::zero(); self.step.len()];
        let mut rates = vec![0.0; self.step.len()];
        for first in (0..count).step_by(WIDTH) {
            right.fill(Lanes::zero());
            let last = (first + WIDTH).min(count);
            for coordinate in first..last {
                right[self.closures + coordinate].0[coordinate - first] = 1.0;
            }
            model.rates.solve_lanes(&self.factors, &mut right, &mut solution);
            for coordinate in first..last {
                let lanes = rates.iter_mut().zip(&solution);
                lanes.for_each(|(rate, lanes)| *rate = lanes.0[coordinate - first]);
                take(coordinate, &rates);
            }
        }
    }
}
