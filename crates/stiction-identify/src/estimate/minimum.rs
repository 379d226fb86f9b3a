//! Minimises the sum of weighted squared residuals and prior by Newton's method within the physical
//! region.
//!
//! Equation (I3) of the book's theory.

use super::constraint::{Constraint, Held, reached};
use super::map::Map;
use super::{Normal, Problem};
use crate::parameter::Kind;
use crate::physical::{self, BodyPrior};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

/// Error of the factor of an effort term that the confidence intervals take into account.
const TERM_ERROR: f64 = 0.5;
/// Error of the excess of static friction that the confidence intervals take into account: static coefficients are up to
/// about twice the sliding ones.
const EXCESS_ERROR: f64 = 1.0;
/// Least strength of the prior on the inertia of a rotor. No physical region bounds this inertia from above.
const ROTOR_FLOOR: f64 = 1e-2;
/// Strength of the prior with which the minimisation begins, and the factor by which it becomes weaker.
const STRONGEST: f64 = 1e8;
const WEAKENING: f64 = 30.0;
/// Decrement of Newton's method at which it has converged, relative to the strength of the prior: the logarithm of the
/// determinant bends by its own size within a unit of the decrement.
const CONVERGED: f64 = 1e-9;
/// Largest number of steps of Newton's method.
const NEWTON_STEPS: usize = 60;

/// Prior of all parameters for one strength.
pub(super) struct Prior<'a> {
    /// Strength of the prior on inertias, in equivalent samples.
    pub(super) strength: f64,
    /// Priors of the inertial parameters of all bodies.
    bodies: &'a [BodyPrior],
    /// Precision (inverse variance) of the quadratic prior on each parameter. It is zero for the
    /// parameters of bodies, whose prior is a divergence.
    precision: Vec<f64>,
}

impl Problem<'_> {
    /// Returns the priors of the inertial parameters of all bodies.
    pub(crate) fn priors(&self) -> Vec<BodyPrior> {
        let prior: Vec<f64> = self.parameters.iter().map(|p| p.prior).collect();
        let bodies = physical::bodies(self.parameters, &prior);
        let each = bodies.iter().filter_map(|(body, inertial)| {
            let first = self.parameters.iter().position(|p| p.body() == Some(*body))?;
            BodyPrior::new(first, inertial, self.options.radius)
        });
        each.collect()
    }

    /// Returns the prior of all parameters for a strength of the prior on inertias. `bodies` are
    /// those of [`Self::priors`].
    pub(super) fn prior<'b>(&self, bodies: &'b [BodyPrior], strength: f64) -> Prior<'b> {
        let precision = self.parameters.iter().map(|p| match p.kind {
            Kind::Mass(_) | Kind::Moment(..) | Kind::Inertia(..) => 0.0,
            Kind::Rotor(_) => strength.max(ROTOR_FLOOR) / (p.scale * p.scale),
            Kind::Term(_) => 1.0 / (TERM_ERROR * TERM_ERROR),
            Kind::StaticExcess(_) => 1.0 / (EXCESS_ERROR * EXCESS_ERROR),
            // Declared friction coefficients are guesses. The prior trusts only their order of
            // magnitude: its standard deviation is ten times the scale.
            _ => 1e-2 / (p.scale * p.scale),
        });
        Prior { strength, bodies, precision: precision.collect() }
    }

    /// Minimises data term and prior, in free coordinates. A value beyond its bound is set to the
    /// bound and held there. Zero is a bound for parameters that must not be negative. The
    /// parameters of bodies also satisfy the inequalities of the options.
    ///
    /// Begins with a strong prior, which becomes weaker step by step: with a weak prior, Newton's method would stall at
    /// the edge of the physical region.
    pub(super) fn minimum(&self, map: &Map, data: &Normal, prior: &Prior<'_>) -> DVector<f64> {
        let mut z = self.start(map, prior.bodies);
        let free = vec![false; map.size()];
        let constraints = self.constraints(map);
        let mut own = STRONGEST;
        while own > WEAKENING * prior.strength {
            z = self.newton(map, data, &self.prior(prior.bodies, own), (&free, &constraints), z);
            own /= WEAKENING;
        }
        self.bounded_minimum(map, data, prior, free, z)
    }

    /// Minimises data term and prior as [`Self::minimum`] does, but starts at coordinates near the minimum.
    pub(super) fn minimum_near(
        &self,
        map: &Map,
        data: &Normal,
        prior: &Prior<'_>,
        start: DVector<f64>,
    ) -> DVector<f64> {
        let found = self.objective(map, data, prior, &start);
        let Some((_, gradient, _)) = found else { return self.minimum(map, data, prior) };
        // Values at a bound stay there if the objective falls beyond it.
        let at_bound = (0..map.size()).map(|k| {
            let [low, high] = self.interval(map, k);
            (start[k] <= low && gradient[k] > 0.0) || (start[k] >= high && gradient[k] < 0.0)
        });
        let at_bound = at_bound.collect();
        self.bounded_minimum(map, data, prior, at_bound, start)
    }

    /// Minimises with the values `at_bound` held at their bounds, and holds others that exceed their bounds.
    fn bounded_minimum(
        &self,
        map: &Map,
        data: &Normal,
        prior: &Prior<'_>,
        mut at_bound: Vec<bool>,
        mut z: DVector<f64>,
    ) -> DVector<f64> {
        let size = map.size();
        let constraints = self.constraints(map);
        let intervals: Vec<[f64; 2]> = (0..size).map(|k| self.interval(map, k)).collect();
        let within = |k: usize, z: f64| z.max(intervals[k][0]).min(intervals[k][1]);
        // In each pass only the value farthest beyond its bound is held, because others may then
        // return inside their bounds.
        for _ in 0..=size {
            z = self.newton(map, data, prior, (&at_bound, &constraints), z);
            let beyond = |k: usize| self.parts(map, k, z[k] - within(k, z[k]));
            let most = (0..size)
                .filter(|&k| !at_bound[k] && within(k, z[k]) != z[k])
                .max_by(|&a, &b| beyond(a).total_cmp(&beyond(b)));
            let Some(k) = most else { break };
            at_bound[k] = true;
            z[k] = within(k, z[k]);
        }
        z
    }

    /// Returns the ratio of the change `z` of a free coordinate, without sign, to the scale of its
    /// parameter.
    fn parts(&self, map: &Map, column: usize, z: f64) -> f64 {
        let scale = self.parameters[map.firsts[column]].scale / map.factor(column).abs();
        z.abs() / scale
    }

    /// Returns the least and the greatest permitted value of a free coordinate; infinite without
    /// bounds.
    pub(super) fn interval(&self, map: &Map, column: usize) -> [f64; 2] {
        let first = &self.parameters[map.firsts[column]];
        // The mass of a body needs no bound, because the divergence keeps it positive.
        let is_nonnegative = first.is_nonnegative() && first.body().is_none();
        let least = if is_nonnegative { 0.0 } else { f64::NEG_INFINITY };
        let own = self.options.bounds.iter().filter_map(|(k, bounds)| {
            let (own, factor) = map.entry(*k)?;
            (own == column).then(|| bounds.map(|bound| bound / factor))
        });
        own.fold([least, f64::INFINITY], |[low, high], own| [low.max(own[0]), high.min(own[1])])
    }

    /// Free coordinates of the prior.
    pub(super) fn start(&self, map: &Map, bodies: &[BodyPrior]) -> DVector<f64> {
        let mut prior: Vec<f64> = self.parameters.iter().map(|p| p.prior).collect();
        for body in bodies {
            prior[body.first..body.first + 10].copy_from_slice(&body.prior);
        }
        DVector::from_fn(map.size(), |column, _| prior[map.firsts[column]] / map.factor(column))
    }

    /// Returns `values` for the computation of divergences. Parameters of a body that are held
    /// constant are replaced by those of the body's prior, whose pseudo-inertia is positive
    /// definite even for a thin body.
    fn thickened(&self, values: &DVector<f64>, priors: &[BodyPrior]) -> DVector<f64> {
        let mut thick = values.clone();
        for body in priors {
            for (k, prior) in (body.first..).zip(body.prior) {
                if self.options.held[k] {
                    thick[k] = prior;
                }
            }
        }
        thick
    }

    /// Returns whether a mass distribution exists for the initial values of each body. Ties between
    /// parameters of different bodies can make the initial values of a body unphysical.
    pub fn begins_physical(&self) -> bool {
        let (map, priors) = (self.map(), self.priors());
        let thick = self.thickened(&map.values(&self.start(&map, &priors)), &priors);
        let is_held = |body: &BodyPrior| {
            self.options.held[body.first..body.first + 10].iter().all(|held| *held)
        };
        priors.iter().all(|body| is_held(body) || body.divergence(thick.as_slice()).is_some())
    }

    /// Minimises with the coordinates `at_bound` held, within `constraints`.
    fn newton(
        &self,
        map: &Map,
        data: &Normal,
        prior: &Prior<'_>,
        (at_bound, constraints): (&[bool], &[Constraint]),
        start: DVector<f64>,
    ) -> DVector<f64> {
        let mut z = start;
        let mut now = self.objective(map, data, prior, &z);
        let mut holds = vec![false; constraints.len()];
        for _ in 0..NEWTON_STEPS {
            let Some((value, mut gradient, mut hessian)) = now.clone() else { break };
            for (k, held) in at_bound.iter().enumerate() {
                if *held {
                    gradient[k] = 0.0;
                    hessian.row_mut(k).fill(0.0);
                    hessian.column_mut(k).fill(0.0);
                    hessian[(k, k)] = 1.0;
                }
            }
            let Some(factor) = Factor::of(&hessian) else { break };
            let held: Vec<usize> = (0..constraints.len()).filter(|&k| holds[k]).collect();
            let directions: Vec<&DVector<f64>> =
                held.iter().map(|&k| &constraints[k].direction).collect();
            let along = Held::of(factor.solve(&gradient), &directions, |own| factor.solve(own));
            let step = &along.step;
            let decrement = gradient.dot(step);
            // Changes of the value below its rounding decide nothing.
            let rounding = 1e-14 * (data.square.abs() + value.abs());
            let first = reached(constraints, &holds, &z, step).filter(|(_, length)| *length < 1.0);
            let mut length = first.map_or(1.0, |(_, length)| length);
            if let Some((k, 0.0)) = first {
                holds[k] = true;
                continue;
            }
            let longest = length;
            let mut best = None;
            while length > 1e-10 * longest {
                let next = &z - step * length;
                if let Some(found) = self.objective(map, data, prior, &next)
                    && found.0 <= value - 1e-4 * length * decrement + rounding
                {
                    best = Some((next, found));
                    break;
                }
                length *= 0.5;
            }
            let Some((next, found)) = best else { break };
            z = next;
            now = Some(found);
            if let Some((k, _)) = first.filter(|_| length == longest) {
                holds[k] = true;
                continue;
            }
            let least = f64::max(CONVERGED * prior.strength.min(1.0), 0.01 * rounding);
            if decrement < least {
                let Some(k) = along.released(least) else { break };
                holds[held[k]] = false;
            }
        }
        z
    }

    /// Computes value, gradient and Hessian of the objective: half the weighted squared residuals
    /// plus the prior. Returns `None` outside the physical region.
    pub(super) fn objective(
        &self,
        map: &Map,
        data: &Normal,
        prior: &Prior<'_>,
        z: &DVector<f64>,
    ) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
        let values = map.values(z);
        let mut value = 0.5 * data.cost(z);
        let mut gradient = &data.matrix * z - &data.right;
        let mut hessian = data.matrix.clone();
        for limit in &data.limits {
            limit.add(z, (&mut value, &mut gradient, &mut hessian));
        }
        let strength = prior.strength;
        let thick = self.thickened(&values, prior.bodies);
        for body in prior.bodies {
            let members = body.first..body.first + 10;
            if self.options.held[members.clone()].iter().all(|held| *held) {
                continue;
            }
            let found = body.divergence(thick.as_slice())?;
            value += strength * found.value;
            for (i, own) in members.clone().enumerate() {
                map.add_slope(&mut gradient, own, strength * found.gradient[i]);
                for (k, other) in members.clone().enumerate() {
                    let bend = strength * found.hessian[(i, k)];
                    map.add_bend(&mut hessian, (own, other), bend);
                }
            }
        }
        for (k, precision) in prior.precision.iter().enumerate() {
            let away = values[k] - self.parameters[k].prior;
            value += 0.5 * precision * away * away;
            map.add_slope(&mut gradient, k, precision * away);
            map.add_bend(&mut hessian, (k, k), *precision);
        }
        value.is_finite().then_some((value, gradient, hessian))
    }

    /// Derivative of the gradient of the objective, in free coordinates, with respect to the logarithm of the strength
    /// of the prior.
    pub(super) fn strength_slope(
        &self,
        map: &Map,
        values: &DVector<f64>,
        prior: &Prior<'_>,
    ) -> DVector<f64> {
        let mut slope = DVector::zeros(map.size());
        let thick = self.thickened(values, prior.bodies);
        for body in prior.bodies {
            let Some(found) = body.divergence(thick.as_slice()) else { continue };
            for i in 0..10 {
                map.add_slope(&mut slope, body.first + i, prior.strength * found.gradient[i]);
            }
        }
        for (k, (precision, p)) in prior.precision.iter().zip(self.parameters).enumerate() {
            // Of the quadratic terms, only those of rotors grow with the strength, above its least
            // value.
            if matches!(p.kind, Kind::Rotor(_)) && prior.strength > ROTOR_FLOOR {
                map.add_slope(&mut slope, k, precision * (values[k] - p.prior));
            }
        }
        slope
    }

    /// Covariance of the gradient of the prior in free coordinates, for a model whose own relative error is `error`.
    /// However strong the prior is, it contains no more information than the model.
    pub(super) fn prior_errors(
        &self,
        map: &Map,
        values: &DVector<f64>,
        prior: &Prior<'_>,
        error: f64,
    ) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(map.size(), map.size());
        let factor = (error * prior.strength).powi(2);
        let thick = self.thickened(values, prior.bodies);
        for body in prior.bodies {
            let Some(found) = body.divergence(thick.as_slice()) else { continue };
            for i in 0..10 {
                for k in 0..10 {
                    let place = (body.first + i, body.first + k);
                    map.add_bend(&mut sum, place, factor * found.hessian[(i, k)]);
                }
            }
        }
        for (k, (precision, p)) in prior.precision.iter().zip(self.parameters).enumerate() {
            // A declared friction coefficient may be wrong by the standard deviation of its prior.
            let error = match p.kind {
                Kind::Rotor(_) => error * p.scale,
                Kind::Term(_) => TERM_ERROR,
                _ => precision.sqrt().recip(),
            };
            if *precision > 0.0 {
                map.add_bend(&mut sum, (k, k), (precision * error).powi(2));
            }
        }
        sum
    }
}

/// Cholesky factor of a matrix that is positive definite up to rounding, with the scale factors of its rows and
/// columns.
struct Factor(DVector<f64>, Cholesky<f64, Dyn>);

impl Factor {
    /// Scales a matrix and factors it after adding the least of a few multiples of the identity that makes it positive
    /// definite; `None` if no multiple suffices.
    fn of(matrix: &DMatrix<f64>) -> Option<Self> {
        let (scales, scaled) = equilibrated(matrix);
        let mut shift = 0.0;
        for _ in 0..8 {
            let mut shifted = scaled.clone();
            (0..shifted.nrows()).for_each(|k| shifted[(k, k)] += shift);
            if let Some(factor) = shifted.cholesky() {
                return Some(Self(scales, factor));
            }
            shift = if shift == 0.0 { 1e-14 } else { 30.0 * shift };
        }
        None
    }

    fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        self.1.solve(&right.component_mul(&self.0)).component_mul(&self.0)
    }
}

/// Inverts a matrix that is positive definite up to rounding; returns `None` if this fails.
pub(super) fn inverse_positive(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let Factor(scales, factor) = Factor::of(matrix)?;
    let inverse = factor.inverse();
    Some(DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |i, k| {
        inverse[(i, k)] * scales[i] * scales[k]
    }))
}

/// Computes `ln det(prior + data) - ln det prior` for a positive definite Hessian of the prior and a positive
/// semidefinite one of the data; `None` if the prior is singular.
///
/// Nearly exact data exceed the prior by more than the rounding of a common sum, whose determinant would be that of
/// the rounding errors. The eigenvalues of the data relative to the prior are therefore computed first; those below
/// the rounding of the largest one count as zero.
pub(super) fn log_growth(prior: &DMatrix<f64>, data: &DMatrix<f64>) -> Option<f64> {
    let (scales, scaled) = equilibrated(prior);
    let lower = scaled.cholesky()?.unpack();
    let size = data.nrows();
    let data = DMatrix::from_fn(size, size, |i, k| data[(i, k)] * scales[i] * scales[k]);
    let half = lower.solve_lower_triangular(&data)?;
    let whole = lower.solve_lower_triangular(&half.transpose())?;
    if !whole.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigenvalues = SymmetricEigen::new((&whole + whole.transpose()) * 0.5).eigenvalues;
    let rounding = size as f64 * f64::EPSILON * eigenvalues.amax();
    Some(eigenvalues.iter().filter(|own| **own > rounding).map(|own| own.ln_1p()).sum())
}

/// Scale factors that make the diagonal one, and the scaled matrix.
fn equilibrated(matrix: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let scales = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 1.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, k| {
        matrix[(i, k)] * scales[i] * scales[k]
    });
    (scales, scaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Data that exceed the prior by up to twenty-six orders of magnitude, along two of three directions.
    #[test]
    fn growth_of_nearly_exact_data() {
        let prior: DMatrix<f64> =
            DMatrix::from_diagonal(&DVector::from_column_slice(&[1e-4, 2.0, 30.0]));
        let rows = DMatrix::from_row_slice(2, 3, &[1.0, 0.3, -0.2, 0.5, -0.7, 0.1]);
        for size in [1.0, 1e6, 1e22] {
            let data = rows.transpose() * &rows * size;
            // By Sylvester's theorem, the determinant is that of the smaller matrix 1 + rows prior^-1 rows^T.
            let inverse = prior.map(|x| if x > 0.0 { x.recip() } else { 0.0 });
            let small = DMatrix::identity(2, 2) + &rows * inverse * rows.transpose() * size;
            let expected = small.determinant().ln();
            let found = log_growth(&prior, &data).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-6, "{size:e}: {found} {expected}");
        }
        assert_eq!(log_growth(&DMatrix::zeros(3, 3), &prior), None);
    }
}
