//! Linear inequalities for the parameters of bodies, such as bounds of a mass or of a centre of mass.
//!
//! The minimisation holds the inequalities by a primal active-set method: it begins at values that satisfy them, ends
//! each step at the first inequality that it reaches, moves along the reached ones, and releases one if the objective
//! falls beyond it. Source: Nocedal, Wright, *Numerical optimization*, 2nd ed. (2006), section 16.5.

use super::Problem;
use super::map::Map;
use nalgebra::{DMatrix, DVector};

/// Inequality `sum of coefficient * value >= least` for parameters of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct Inequality {
    /// Indices of the parameters and their coefficients.
    pub terms: Vec<(usize, f64)>,
    /// Least permitted value of the sum.
    pub least: f64,
}

/// Distance from a wall, in free coordinates, up to which a point lies on it. Free coordinates are parts of the
/// parameters' scales. Rounding errors of many steps along the wall are smaller.
const TOUCHES: f64 = 1e-9;
/// Distance between the unit directions of two walls up to which the walls are parallel.
const PARALLEL: f64 = 1e-12;

/// Inequality `direction . z >= least` in free coordinates, with a direction of unit length.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    pub(super) direction: DVector<f64>,
    least: f64,
}

impl Wall {
    /// Returns the distance from the wall; negative beyond it.
    pub(super) fn distance(&self, z: &DVector<f64>) -> f64 {
        self.direction.dot(z) - self.least
    }

    /// Returns whether a point lies on the wall.
    pub(super) fn touches(&self, z: &DVector<f64>) -> bool {
        self.distance(z) <= TOUCHES * (1.0 + self.least.abs())
    }
}

impl Problem<'_> {
    /// Returns the inequalities of the options in free coordinates, without those whose parameters are all held. Of
    /// inequalities with the same direction, such as those of tied parameters, only the narrowest one remains: the
    /// walls that hold a step must be independent, and each bound reduces the covariance once.
    pub(super) fn walls(&self, map: &Map) -> Vec<Wall> {
        let mut walls: Vec<Wall> = Vec::new();
        for own in &self.options.inequalities {
            let mut direction = DVector::zeros(map.size());
            let mut least = own.least;
            for &(k, coefficient) in &own.terms {
                least -= coefficient * map.base[k];
                map.add_slope(&mut direction, k, coefficient);
            }
            let size = direction.norm();
            if size == 0.0 {
                continue;
            }
            let (direction, least) = (direction / size, least / size);
            match walls.iter_mut().find(|wall| (&wall.direction - &direction).norm() <= PARALLEL) {
                Some(wall) => wall.least = wall.least.max(least),
                None => walls.push(Wall { direction, least }),
            }
        }
        walls
    }

    /// Returns the values with which the minimisation begins: those of the model, with some thickness for thin bodies.
    pub fn initial(&self) -> Vec<f64> {
        let (map, priors) = (self.map(), self.priors());
        map.values(&self.start(&map, &priors)).as_slice().to_vec()
    }
}

/// Step of Newton's method along the walls that hold it.
pub(super) struct Held {
    /// Change of the coordinates; the step subtracts it.
    pub(super) step: DVector<f64>,
    /// Multiplier of each wall; the objective falls beyond the wall if it is positive.
    multipliers: DVector<f64>,
    /// Squared lengths of the walls' directions in the metric of the inverse Hessian.
    squares: DVector<f64>,
}

impl Held {
    /// Projects `free`, the step without walls, onto the `walls`. `solve` multiplies by the inverse Hessian. `None` if
    /// the walls depend on each other.
    pub(super) fn of(
        free: DVector<f64>,
        walls: &[&DVector<f64>],
        solve: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) -> Option<Self> {
        let turned: Vec<DVector<f64>> = walls.iter().map(|wall| solve(wall)).collect();
        let count = walls.len();
        let matrix = DMatrix::from_fn(count, count, |i, k| walls[i].dot(&turned[k]));
        let along = DVector::from_fn(count, |i, _| walls[i].dot(&free));
        let squares = matrix.diagonal();
        let multipliers = match count {
            0 => along,
            _ => matrix.cholesky()?.solve(&along),
        };
        let mut step = free;
        for (turned, multiplier) in turned.iter().zip(multipliers.iter()) {
            step.axpy(-multiplier, turned, 1.0);
        }
        Some(Self { step, multipliers, squares })
    }

    /// Returns the index of the wall without which the objective falls most inside it, if the objective falls by more
    /// than half of `least`.
    pub(super) fn released(&self, least: f64) -> Option<usize> {
        let falls = |k: usize| self.multipliers[k].powi(2) * self.squares[k];
        let each = (0..self.squares.len()).filter(|&k| self.multipliers[k] < 0.0);
        let best = each.max_by(|&a, &b| falls(a).total_cmp(&falls(b)))?;
        (falls(best) > least).then_some(best)
    }
}

/// Returns the first of the `walls` that `z - length * step` reaches and the length there; `held` walls do not count.
pub(super) fn reached(
    walls: &[Wall],
    held: &[bool],
    z: &DVector<f64>,
    step: &DVector<f64>,
) -> Option<(usize, f64)> {
    let size = step.norm();
    let each = walls.iter().zip(held).enumerate().filter_map(|(k, (wall, held))| {
        let speed = wall.direction.dot(step);
        (!held && speed > 1e-13 * size).then(|| (k, wall.distance(z).max(0.0) / speed))
    });
    each.min_by(|a, b| a.1.total_cmp(&b.1))
}
