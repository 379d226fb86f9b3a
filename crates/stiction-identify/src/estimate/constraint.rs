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

/// Slack of a constraint, in free coordinates, up to which it is active. Free coordinates are parts of the parameters'
/// scales. Rounding errors of many steps along the constraint are smaller.
const ACTIVE: f64 = 1e-9;
/// Distance between the unit directions of two constraints up to which the constraints are parallel.
const PARALLEL: f64 = 1e-12;
/// Square of the part of a constraint's direction that others leave, relative to the square of the direction, up to
/// which the constraint depends on them. Both are in the metric of the inverse Hessian. Rounding errors of the square are
/// some 1e-15.
const DEPENDENT: f64 = 1e-13;

/// Inequality `direction . z >= least` in free coordinates, with a direction of unit length.
#[derive(Clone, Debug)]
pub(super) struct Constraint {
    pub(super) direction: DVector<f64>,
    least: f64,
}

impl Constraint {
    /// Returns the slack of the constraint at a point; negative beyond the constraint.
    fn slack(&self, z: &DVector<f64>) -> f64 {
        self.direction.dot(z) - self.least
    }

    /// Returns whether the constraint is active at a point.
    pub(super) fn is_active(&self, z: &DVector<f64>) -> bool {
        self.slack(z) <= ACTIVE * (1.0 + self.least.abs())
    }
}

impl Problem<'_> {
    /// Returns the inequalities of the options in free coordinates, without those whose parameters are all held. Of
    /// inequalities with the same direction, such as those of tied parameters, only the narrowest one remains: the
    /// constraints that hold a step must be independent, and each bound reduces the covariance once.
    pub(super) fn constraints(&self, map: &Map) -> Vec<Constraint> {
        let mut constraints: Vec<Constraint> = Vec::new();
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
            let is_parallel =
                |known: &&mut Constraint| (&known.direction - &direction).norm() <= PARALLEL;
            match constraints.iter_mut().find(is_parallel) {
                Some(known) => known.least = known.least.max(least),
                None => constraints.push(Constraint { direction, least }),
            }
        }
        constraints
    }

    /// Returns the values with which the minimisation begins: those of the model, with some thickness for thin bodies.
    pub fn initial(&self) -> Vec<f64> {
        let (map, priors) = (self.map(), self.priors());
        map.values(&self.start(&map, &priors)).as_slice().to_vec()
    }
}

/// Step of Newton's method along the active constraints, and their multipliers.
pub(super) struct Held {
    /// Change of the coordinates; the step subtracts it.
    pub(super) step: DVector<f64>,
    /// Multiplier of each constraint; the objective falls beyond the constraint if it is positive.
    multipliers: DVector<f64>,
    /// Squared lengths of the constraints' directions in the metric of the inverse Hessian.
    squares: DVector<f64>,
}

impl Held {
    /// Projects `free`, the step without constraints, onto the `constraints`, each given by its direction. `solve`
    /// multiplies by the inverse Hessian. A constraint that depends on those before it is satisfied by the same step;
    /// its multiplier is zero.
    pub(super) fn of(
        free: DVector<f64>,
        constraints: &[&DVector<f64>],
        solve: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) -> Self {
        let turned: Vec<DVector<f64>> =
            constraints.iter().map(|constraint| solve(constraint)).collect();
        let count = constraints.len();
        let matrix = DMatrix::from_fn(count, count, |i, k| constraints[i].dot(&turned[k]));
        let (mut independent, mut factor) = (Vec::new(), None);
        for k in 0..count {
            independent.push(k);
            let own = matrix.select_rows(&independent).select_columns(&independent);
            let last = independent.len() - 1;
            let found = own
                .cholesky()
                .filter(|found| found.l_dirty()[(last, last)].powi(2) > DEPENDENT * matrix[(k, k)]);
            match found {
                Some(found) => factor = Some(found),
                None => drop(independent.pop()),
            }
        }
        let along = independent.iter().map(|&k| constraints[k].dot(&free));
        let along = DVector::from_iterator(independent.len(), along);
        let mut multipliers = DVector::zeros(count);
        if let Some(factor) = factor {
            let found = factor.solve(&along);
            independent.iter().zip(found.iter()).for_each(|(&k, own)| multipliers[k] = *own);
        }
        let mut step = free;
        for (turned, multiplier) in turned.iter().zip(multipliers.iter()) {
            step.axpy(-multiplier, turned, 1.0);
        }
        Self { step, multipliers, squares: matrix.diagonal() }
    }

    /// Returns the index of the constraint without which the objective falls most inside it, if the objective falls by
    /// more than half of `least`.
    pub(super) fn released(&self, least: f64) -> Option<usize> {
        let falls = |k: usize| self.multipliers[k].powi(2) * self.squares[k];
        let each = (0..self.squares.len()).filter(|&k| self.multipliers[k] < 0.0);
        let best = each.max_by(|&a, &b| falls(a).total_cmp(&falls(b)))?;
        (falls(best) > least).then_some(best)
    }
}

/// Returns the first of the `constraints` that `z - length * step` reaches and the length there; `held` constraints do
/// not count.
pub(super) fn reached(
    constraints: &[Constraint],
    held: &[bool],
    z: &DVector<f64>,
    step: &DVector<f64>,
) -> Option<(usize, f64)> {
    let size = step.norm();
    let each = constraints.iter().zip(held).enumerate().filter_map(|(k, (constraint, held))| {
        let speed = constraint.direction.dot(step);
        (!held && speed > 1e-13 * size).then(|| (k, constraint.slack(z).max(0.0) / speed))
    });
    each.min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three constraints whose directions lie in one plane, the first two determine the step in any order, and the step
    /// satisfies the third.
    #[test]
    fn dependent_constraints_hold_together() {
        let unit = |numbers: [f64; 3]| DVector::from_row_slice(&numbers).normalize();
        let directions = [unit([1.0, 0.2, 0.0]), unit([0.3, 1.0, 0.0]), unit([1.0, 0.7, 0.0])];
        let free = DVector::from_row_slice(&[1.0, -2.0, 3.0]);
        let inverse = DMatrix::from_row_slice(3, 3, &[2.0, 0.1, 0.3, 0.1, 1.0, 0.2, 0.3, 0.2, 0.5]);
        let held = |order: &[usize]| {
            let constraints: Vec<_> = order.iter().map(|&k| &directions[k]).collect();
            Held::of(free.clone(), &constraints, |own| &inverse * own)
        };
        let two = held(&[0, 1]);
        for order in [[0, 1, 2], [0, 2, 1], [2, 1, 0]] {
            let three = held(&order);
            assert!((&three.step - &two.step).norm() < 1e-12, "{order:?}: {}", three.step);
            assert_eq!(three.multipliers[2], 0.0, "{order:?}");
            for direction in &directions {
                assert!(direction.dot(&three.step).abs() < 1e-12, "{order:?}: {}", three.step);
            }
        }
    }
}
