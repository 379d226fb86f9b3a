//! Equations that friction must satisfy to hold a configuration, and distributions of friction over
//! the interfaces.
//!
//! Equation (R5) of the book's theory.

use super::couplings::Couplings;
use super::map::FrictionMap;
use crate::linalg::Svd;
use nalgebra::{DMatrix, DVector};

/// Largest number of iterations of the iteratively reweighted least squares.
const STEPS: usize = 200;
/// Factor by which each iteration reduces the smoothing of the norms near zero.
const SHARPEN: f64 = 0.8;
/// Number of iterative refinements of each solution for the friction forces.
const REFINEMENTS: usize = 3;
/// Equations count as satisfied if their residual is at most this fraction of the right-hand side.
const MET: f64 = 1e-12;
/// Relative size below which the following count as zero: efforts of unpowered actuators, singular
/// values, and the part of the equations that friction does not influence.
pub(super) const NOTHING: f64 = 1e-10;

/// Linear equation for the friction forces, `slopes . frictions = missing`. It requires that the
/// effort of an unpowered actuator or the acceleration of a local degree of freedom vanishes.
pub(super) struct Equation {
    /// Coefficients of all friction components.
    slopes: Vec<f64>,
    pub(super) missing: f64,
    /// Interfaces whose friction influences the equation, see [`FrictionMap::reach`].
    pub(super) reach: Vec<usize>,
}

impl Equation {
    /// Requires that the effort of `actuator` vanishes. `drive` is the effort without static
    /// friction, and `scale` a factor that scales the equation. A scaled effort that is negligible
    /// compared with `largest` counts as zero.
    pub(super) fn of_effort(
        map: &FrictionMap<'_>,
        couplings: &Couplings,
        (actuator, drive, scale): (usize, f64, f64),
        largest: f64,
    ) -> Self {
        let slopes = map.slopes(actuator).iter().map(|slope| slope * scale).collect();
        let demand = -drive * scale;
        let missing = if demand.abs() <= NOTHING * largest { 0.0 } else { demand };
        Self::new(map, couplings, slopes, missing)
    }

    /// Requires that the acceleration of a local degree of freedom vanishes. `None` if friction
    /// does not influence this acceleration.
    pub(super) fn of_spin(
        map: &FrictionMap<'_>,
        couplings: &Couplings,
        spin: usize,
    ) -> Option<Self> {
        // The acceleration is divided by the largest acceleration that a unit friction causes.
        let row = map.spin_slopes(spin);
        let size = row.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        let slopes = row.iter().map(|x| x / size).collect();
        (size > 0.0).then(|| Self::new(map, couplings, slopes, 0.0))
    }

    fn new(map: &FrictionMap<'_>, couplings: &Couplings, slopes: Vec<f64>, missing: f64) -> Self {
        let reach = map.reach(&slopes, couplings.influencing());
        Self { slopes, missing, reach }
    }

    /// Returns the largest influence of a friction component on the equation.
    pub(super) fn strength(&self) -> f64 {
        self.slopes.iter().fold(0.0, |most, slope| most.max(slope.abs()))
    }
}

/// System of linear equations for the friction forces, `slopes * frictions = missing`.
pub(super) struct Demand {
    pub(super) slopes: DMatrix<f64>,
    pub(super) missing: DVector<f64>,
}

/// Distribution of friction over the interfaces, with a lower bound that shows how close it is to
/// the optimum.
pub(super) struct Share {
    pub(super) frictions: Vec<f64>,
    /// Lower bound, over all distributions, of the largest ratio of friction to weight.
    pub(super) least: f64,
}

impl Demand {
    /// Collects the equations for the friction of the interfaces in `map`.
    pub(super) fn new(map: &FrictionMap<'_>, equations: &[&Equation]) -> Self {
        let slope = |i: usize, k: usize| equations[i].slopes[map.global(k)];
        let slopes = DMatrix::from_fn(equations.len(), map.len(), slope);
        let missing = equations.iter().map(|equation| equation.missing);
        Self { slopes, missing: DVector::from_iterator(equations.len(), missing) }
    }

    /// Reduces the equations to linearly independent ones; `None` if no friction satisfies the
    /// equations.
    pub(super) fn independent(&self) -> Option<Self> {
        let svd = Svd::new(&self.slopes.transpose());
        let rank = svd.rank(NOTHING);
        // Linear combinations of the equations that friction influences, and those that it does not
        // influence.
        let inside = svd.v.columns(0, rank).transpose();
        let outside = svd.v.columns(rank, svd.v.ncols() - rank).transpose();
        let lost = (outside * &self.missing).norm();
        (lost.is_finite() && lost <= NOTHING * self.missing.norm())
            .then(|| Self { slopes: &inside * &self.slopes, missing: inside * &self.missing })
    }

    /// Returns the friction that satisfies linearly independent equations. `None` if this friction
    /// is not unique, that is, if there are fewer equations than friction components, or if it
    /// cannot be computed accurately.
    pub(super) fn unique(&self) -> Option<Vec<f64>> {
        if self.slopes.nrows() != self.slopes.ncols() {
            return None;
        }
        let factors = self.slopes.clone().lu();
        let mut frictions = factors.solve(&self.missing)?;
        for _ in 0..REFINEMENTS {
            let left = &self.missing - &self.slopes * &frictions;
            frictions += factors.solve(&left)?;
        }
        let left = (&self.missing - &self.slopes * &frictions).norm();
        (left <= MET * self.missing.norm()).then(|| frictions.as_slice().to_vec())
    }

    /// Returns linearly independent equations for the friction of interfaces with nonzero weight;
    /// `None` if the friction of these interfaces cannot satisfy the equations.
    pub(super) fn borne_by(&self, map: &FrictionMap<'_>, weights: &[[f64; 2]]) -> Option<Self> {
        let mut borne = Self { slopes: self.slopes.clone(), missing: self.missing.clone() };
        if weights.iter().all(|weight| *weight != [0.0; 2]) {
            return Some(borne);
        }
        for (k, owner) in map.owners().enumerate() {
            if weights[owner] == [0.0; 2] {
                borne.slopes.column_mut(k).fill(0.0);
            }
        }
        borne.independent()
    }

    /// Distributes friction such that the largest ratio of the friction of an interface to its
    /// weight is minimal: `min max |f_c| / w_c` subject to the equations. The dual problem
    /// minimises the power that friction equal to the weights dissipates, over all motions in which
    /// `missing` has unit power. This sum of norms is minimised by iteratively reweighted least
    /// squares; each iteration yields a distribution and a motion.
    ///
    /// Each interface has a weight for forward and one for backward friction.
    pub(super) fn share(&self, map: &FrictionMap<'_>, weights: &[[f64; 2]]) -> Option<Share> {
        self.share_until(map, weights, |_, _| false)
    }

    /// Returns true if every distribution of friction has an interface whose friction exceeds its
    /// weight, see [`Self::share`].
    pub(super) fn exceeds(&self, map: &FrictionMap<'_>, weights: &[[f64; 2]]) -> bool {
        if self.slopes.nrows() == 1 {
            // A single equation determines the motion up to a factor.
            let missing = self.missing[0];
            let rates: Vec<f64> = self.slopes.iter().map(|x| x * missing.signum()).collect();
            let own = of_sign(map, &rates, weights);
            let spent: f64 = map.sizes(&rates).iter().zip(&own).map(|(x, own)| x * own).sum();
            return spent > 0.0 && missing.abs() > spent;
        }
        // Either bound of the optimum may decide long before the bounds agree.
        let decided = |least, attained| least > 1.0 || attained <= 1.0;
        self.share_until(map, weights, decided).is_some_and(|share| share.least > 1.0)
    }

    /// Distributes friction as [`Self::share`]. Stops as soon as `is_enough` returns true for the
    /// lower bound of the optimum and for the smallest ratio found.
    fn share_until(
        &self,
        map: &FrictionMap<'_>,
        weights: &[[f64; 2]],
        is_enough: impl Fn(f64, f64) -> bool,
    ) -> Option<Share> {
        let owners: Vec<usize> = map.owners().collect();
        let transposed = self.slopes.transpose();
        let mut scaled = self.slopes.clone();
        let (mut rates, mut frictions) =
            (DVector::zeros(owners.len()), DVector::zeros(owners.len()));
        let mut best: Option<Share> = None;
        let mut attained = f64::INFINITY;
        let mut factors: Vec<f64> =
            owners.iter().map(|&owner| weights[owner][0].max(weights[owner][1])).collect();
        let mut sharp = 1.0;
        for _ in 0..STEPS {
            scaled.copy_from(&self.slopes);
            for (mut column, factor) in scaled.column_iter_mut().zip(&factors) {
                column *= *factor;
            }
            let gram = (&scaled * &transposed).lu();
            let Some(motion) = gram.solve(&self.missing) else { break };
            let power = motion.dot(&self.missing);
            if !(power > 0.0 && power.is_finite()) {
                break;
            }
            rates.gemv_tr(1.0, &self.slopes, &motion, 0.0);
            frictions.gemv_tr(1.0, &scaled, &motion, 0.0);
            // Near convergence the factors differ by many orders of magnitude; iterative refinement
            // removes the round-off.
            for _ in 0..REFINEMENTS {
                let left = &self.missing - &self.slopes * &frictions;
                if let Some(correction) = gram.solve(&left) {
                    frictions.gemv_tr(1.0, &scaled, &correction, 1.0);
                }
            }
            let left = (&self.missing - &self.slopes * &frictions).norm();
            if left.is_nan() || left > MET * self.missing.norm() {
                break;
            }
            // Friction has the sign of the sliding rate.
            let own = of_sign(map, rates.as_slice(), weights);
            let speeds = map.sizes(rates.as_slice());
            let spent: f64 = speeds.iter().zip(&own).map(|(speed, weight)| speed * weight).sum();
            let known = best.as_ref().map_or(0.0, |share| share.least);
            let least = known.max(power / spent);
            let part = ratio(&map.sizes(frictions.as_slice()), &own);
            match &mut best {
                Some(share) if part >= attained => share.least = least,
                _ => best = Some(Share { frictions: frictions.as_slice().to_vec(), least }),
            }
            attained = attained.min(part);
            if attained - least <= 1e-12 * least || is_enough(least, attained) {
                break;
            }
            let largest = speeds.iter().copied().fold(0.0, f64::max);
            sharp *= SHARPEN;
            let factor =
                |&owner: &usize| own[owner] / (f64::hypot(speeds[owner] / largest, sharp) + 1e-14);
            factors = owners.iter().map(factor).collect();
        }
        best
    }
}

/// Selects, for each interface, the value for forward or for backward friction, according to the
/// sign of the friction.
pub(super) fn of_sign(map: &FrictionMap<'_>, frictions: &[f64], numbers: &[[f64; 2]]) -> Vec<f64> {
    let mut chosen: Vec<f64> = numbers.iter().map(|[forward, _]| *forward).collect();
    for (owner, friction) in map.owners().zip(frictions) {
        // If both values are equal, as for ball joints, the sign does not matter.
        if *friction < 0.0 {
            chosen[owner] = numbers[owner][1];
        }
    }
    chosen
}

/// Returns the largest ratio of an entry of `sizes` to the corresponding entry of `weights`.
pub(super) fn ratio(sizes: &[f64], weights: &[f64]) -> f64 {
    let each = sizes.iter().zip(weights).map(|(&size, &weight)| match size {
        0.0 => 0.0,
        _ if weight > 0.0 => size / weight,
        _ => f64::INFINITY,
    });
    each.fold(0.0, f64::max)
}
