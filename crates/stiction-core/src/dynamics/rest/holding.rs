//! Self-locking: configurations that static friction holds without actuator efforts.
//!
//! Equation (R5) of the book's theory.

use super::map::{Couplings, FrictionMap};
use super::outer::greatest_frictions;
use crate::linalg::Svd;
use core::cell::OnceCell;
use nalgebra::{DMatrix, DVector};

/// Result of the self-locking test, which decides whether static friction holds a configuration
/// while some actuators exert no effort.
#[derive(Clone, Debug, PartialEq)]
pub struct Holding {
    /// Verdict of the test. [`Verdict::Holds`] and [`Verdict::Slips`] are proven.
    pub verdict: Verdict,
    /// Guaranteed lower and upper bounds of the common factor on all static friction coefficients
    /// that is needed to hold the configuration. The upper bound is infinite if no sufficient
    /// factor was found.
    pub needed: (f64, f64),
    /// Friction forces that hold the configuration, N: for each interface, the components along its
    /// DOFs, with the sign of the sliding that they oppose. Empty if the verdict is not
    /// [`Verdict::Holds`], or if it follows from an effort interval that contains zero.
    pub frictions: Vec<Vec<f64>>,
}

/// Verdict of the self-locking test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Friction forces within all limits hold the configuration.
    Holds,
    /// For some motion the load supplies more power than friction can dissipate.
    Slips,
    /// Neither holding nor slipping is proven.
    Undecided,
}

/// Largest number of iterations that alternate between normal forces and friction distribution.
const ROUNDS: usize = 60;
/// Largest number of iterations of the iteratively reweighted least squares.
const STEPS: usize = 200;
/// Factor by which each iteration reduces the smoothing of the norms near zero.
const SHARPEN: f64 = 0.8;
/// Number of iterative refinements of each solution for the friction forces.
const REFINEMENTS: usize = 3;
/// Equations count as satisfied if their residual is at most this fraction of the right-hand side.
const MET: f64 = 1e-12;
/// Number of bisections in the search for the largest insufficient factor on the friction
/// coefficients.
const HALVINGS: usize = 40;
/// Largest factor on the friction coefficients that is tried. A larger sufficient factor counts as
/// infinite.
const MOST: f64 = 1e6;
/// Relative size below which the following count as zero: efforts of unpowered actuators, singular
/// values, and the part of the equations that friction does not influence.
const NOTHING: f64 = 1e-10;
/// Bounds count as equal if they differ by less than this fraction.
const SAME: f64 = 1e-9;

/// Linear equations for the friction forces, `slopes * frictions = missing`. They require that the
/// efforts of unpowered actuators and the accelerations of local degrees of freedom vanish.
pub(super) struct Demand {
    slopes: DMatrix<f64>,
    missing: DVector<f64>,
}

/// Bounds of the influence of friction on normal forces, see [`FrictionMap::couplings`]. They are
/// computed once and shared by all [`Demand`]s at a configuration.
#[derive(Default)]
pub(super) struct LoadBounds {
    couplings: OnceCell<Couplings>,
}

/// Distribution of friction over the interfaces, with a lower bound that shows how close it is to
/// the optimum.
struct Share {
    frictions: Vec<f64>,
    /// Lower bound, over all distributions, of the largest ratio of friction to weight.
    least: f64,
}

impl Demand {
    /// Sets up the equations. `efforts` lists the efforts that must vanish: the index of the
    /// actuator, the frictionless effort, and a factor that scales the equation. The accelerations
    /// of all `spins` local degrees of freedom must vanish as well. Scaled efforts that are
    /// negligible compared with `largest` count as zero.
    pub(super) fn new(
        map: &FrictionMap<'_>,
        efforts: &[(usize, f64, f64)],
        spins: usize,
        largest: f64,
    ) -> Self {
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut missing = Vec::new();
        for &(actuator, drive, scale) in efforts {
            rows.push(map.slopes(actuator).iter().map(|slope| slope * scale).collect());
            let demand = -drive * scale;
            missing.push(if demand.abs() <= NOTHING * largest { 0.0 } else { demand });
        }
        for spin in 0..spins {
            // The acceleration is divided by the largest acceleration that a unit friction causes.
            let row = map.spin_slopes(spin);
            let size = row.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
            if size > 0.0 {
                rows.push(row.iter().map(|x| x / size).collect());
                missing.push(0.0);
            }
        }
        let slopes = DMatrix::from_fn(rows.len(), map.len(), |i, k| rows[i][k]);
        Self { slopes, missing: DVector::from_vec(missing) }
    }

    /// Reduces the equations to linearly independent ones; `None` if no friction satisfies the
    /// equations.
    fn independent(&self) -> Option<Self> {
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
    fn unique(&self) -> Option<Vec<f64>> {
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
    fn borne_by(&self, map: &FrictionMap<'_>, weights: &[[f64; 2]]) -> Option<Self> {
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
    fn share(&self, map: &FrictionMap<'_>, weights: &[[f64; 2]]) -> Option<Share> {
        let owners: Vec<usize> = map.owners().collect();
        let mut best: Option<Share> = None;
        let mut attained = f64::INFINITY;
        let mut factors: Vec<f64> =
            owners.iter().map(|&owner| weights[owner][0].max(weights[owner][1])).collect();
        let mut sharp = 1.0;
        for _ in 0..STEPS {
            let mut scaled = self.slopes.clone();
            for (mut column, factor) in scaled.column_iter_mut().zip(&factors) {
                column *= *factor;
            }
            let gram = (&scaled * self.slopes.transpose()).lu();
            let Some(motion) = gram.solve(&self.missing) else { break };
            let power = motion.dot(&self.missing);
            if !(power > 0.0 && power.is_finite()) {
                break;
            }
            let rates = self.slopes.tr_mul(&motion);
            let mut frictions = scaled.tr_mul(&motion);
            // Near convergence the factors differ by many orders of magnitude; iterative refinement
            // removes the round-off.
            for _ in 0..REFINEMENTS {
                let left = &self.missing - &self.slopes * &frictions;
                if let Some(correction) = gram.solve(&left) {
                    frictions += scaled.tr_mul(&correction);
                }
            }
            let left = (&self.missing - &self.slopes * &frictions).norm();
            if left.is_nan() || left > MET * self.missing.norm() {
                break;
            }
            let frictions: Vec<f64> = frictions.iter().copied().collect();
            // Friction has the sign of the sliding rate.
            let own = of_sign(map, rates.as_slice(), weights);
            let speeds = map.sizes(rates.as_slice());
            let spent: f64 = speeds.iter().zip(&own).map(|(speed, weight)| speed * weight).sum();
            let known = best.as_ref().map_or(0.0, |share| share.least);
            let least = known.max(power / spent);
            let part = ratio(&map.sizes(&frictions), &own);
            match &mut best {
                Some(share) if part >= attained => share.least = least,
                _ => best = Some(Share { frictions, least }),
            }
            attained = attained.min(part);
            if attained - least <= 1e-12 * least {
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
fn of_sign(map: &FrictionMap<'_>, frictions: &[f64], numbers: &[[f64; 2]]) -> Vec<f64> {
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
fn ratio(sizes: &[f64], weights: &[f64]) -> f64 {
    let each = sizes.iter().zip(weights).map(|(&size, &weight)| match size {
        0.0 => 0.0,
        _ if weight > 0.0 => size / weight,
        _ => f64::INFINITY,
    });
    each.fold(0.0, f64::max)
}

/// Computes the friction limits of each interface, N, for forward and backward sliding under the
/// normal forces `loads`, N.
fn limits(map: &FrictionMap<'_>, loads: &[f64]) -> Vec<[f64; 2]> {
    let limit = |(interface, load): (usize, &f64)| map.coefficients(interface).map(|mu| mu * load);
    loads.iter().enumerate().map(limit).collect()
}

/// Decides whether friction forces within their limits satisfy the equations in `demand`.
pub(super) fn hold(map: &FrictionMap<'_>, bounds: &LoadBounds, demand: &Demand) -> Holding {
    let nothing = vec![0.0; map.len()];
    if demand.missing.norm() == 0.0 {
        return Holding {
            verdict: Verdict::Holds,
            needed: (0.0, 0.0),
            frictions: split(map, &nothing),
        };
    }
    let slips = Holding {
        verdict: Verdict::Slips,
        needed: (f64::INFINITY, f64::INFINITY),
        frictions: Vec::new(),
    };
    let Some(demand) = demand.independent() else { return slips };
    let unique = demand.unique();
    let (enough, frictions) = match &unique {
        Some(frictions) => {
            let own = limits(map, &map.loads(frictions));
            let part = ratio(&map.sizes(frictions), &of_sign(map, frictions, &own));
            (part, frictions.clone())
        }
        None => follow_loads(map, &demand),
    };
    let known = (enough, frictions.as_slice());
    let not_enough =
        greatest_insufficient(map, bounds, &demand, known, unique.is_some()).min(enough);
    let (verdict, frictions) = match (not_enough, enough) {
        (_, enough) if enough <= 1.0 + 1e-12 => (Verdict::Holds, split(map, &frictions)),
        (not_enough, _) if not_enough > 1.0 => (Verdict::Slips, Vec::new()),
        _ => (Verdict::Undecided, Vec::new()),
    };
    // Extremely large factors are due to normal forces that are round-off.
    let enough = if enough > MOST { f64::INFINITY } else { enough };
    let is_same = enough.is_finite() && enough - not_enough <= SAME * enough;
    let not_enough = if is_same { enough } else { not_enough };
    Holding { verdict, needed: (not_enough, enough), frictions }
}

/// Iterates between friction distributions and the normal forces that they cause. Returns the
/// factor on the friction coefficients that the best distribution needs, and this distribution.
/// Each distribution is checked with its own normal forces, so the factor is attained.
fn follow_loads(map: &FrictionMap<'_>, demand: &Demand) -> (f64, Vec<f64>) {
    let mut frictions = vec![0.0; map.len()];
    let mut best = (f64::INFINITY, frictions.clone());
    let mut weights = limits(map, &map.loads(&frictions));
    for _ in 0..ROUNDS {
        let borne = demand.borne_by(map, &weights);
        let Some(share) = borne.and_then(|borne| borne.share(map, &weights)) else { break };
        frictions = share.frictions;
        let own = limits(map, &map.loads(&frictions));
        let part = ratio(&map.sizes(&frictions), &of_sign(map, &frictions, &own));
        let settled = (part - best.0).abs() <= 1e-13 * part;
        if part < best.0 {
            best = (part, frictions.clone());
        }
        if settled {
            break;
        }
        // Halves each change, so that alternating normal forces converge as well.
        for (weight, own) in weights.iter_mut().zip(own) {
            *weight = [0, 1].map(|way| 0.5 * (weight[way] + own[way]));
        }
    }
    best
}

/// Returns the largest factor on the friction coefficients, at most `most`, that is guaranteed to
/// be insufficient.
///
/// Every solution equals one solution, `known`, plus friction without effect on the equations.
/// Normal forces can therefore be bounded relative to their values for `known` as well as for zero
/// friction. Relative to `known`, only friction without effect on the equations changes them.
///
/// `is_unique` is true if `known` is the only solution.
fn greatest_insufficient(
    map: &FrictionMap<'_>,
    bounds: &LoadBounds,
    demand: &Demand,
    (most, known): (f64, &[f64]),
    is_unique: bool,
) -> f64 {
    // The transpose has few columns, and therefore few singular vectors.
    let svd = Svd::new(&demand.slopes.transpose());
    let rank = svd.rank(NOTHING);
    let reach = svd.u.columns(0, rank);
    let without_effect = |vector: &[f64]| {
        let vector = DVector::from_column_slice(vector);
        let rest = &vector - reach * reach.tr_mul(&vector);
        rest.iter().copied().collect::<Vec<f64>>()
    };
    let plain_loads: Vec<f64> = (0..map.interfaces()).map(|c| map.load_without(c)).collect();
    let plain = bounds.couplings.get_or_init(|| map.couplings());
    let least: Vec<f64> = match known.iter().any(|x| *x != 0.0) {
        true => known.iter().zip(without_effect(known)).map(|(a, b)| a - b).collect(),
        false => {
            let amounts = svd.v.columns(0, rank).tr_mul(&demand.missing);
            let amounts = amounts.component_div(&svd.singular_values.rows(0, rank));
            (reach * amounts).iter().copied().collect()
        }
    };
    let bound_loads = map.loads(&least);
    let reached: Vec<&[f64]> = svd.u.as_slice().chunks_exact(map.len()).take(rank).collect();
    let bound = &map.couplings_without(plain, &reached);
    let falls_short = |part: f64| {
        let frictions = [(&plain_loads, plain), (&bound_loads, bound)]
            .map(|(loads, couplings)| greatest_frictions(map, loads, couplings, part));
        let greatest = match frictions {
            [Some(a), Some(b)] => {
                let least = |(a, b): (&[f64; 2], &[f64; 2])| [a[0].min(b[0]), a[1].min(b[1])];
                a.iter().zip(&b).map(least).collect()
            }
            [Some(one), None] | [None, Some(one)] => one,
            [None, None] => return false,
        };
        if is_unique {
            return ratio(&map.sizes(known), &of_sign(map, known, &greatest)) > 1.0;
        }
        match demand.borne_by(map, &greatest) {
            None => true,
            Some(borne) => borne.share(map, &greatest).is_some_and(|share| share.least > 1.0),
        }
    };
    let (mut low, mut high) = (0.0, most.min(MOST));
    if falls_short(high) {
        return if most > MOST { f64::INFINITY } else { most };
    }
    for _ in 0..HALVINGS {
        // Geometric mean, because fractions span many orders of magnitude.
        let middle =
            if low > 0.0 && high > 4.0 * low { (low * high).sqrt() } else { 0.5 * (low + high) };
        if falls_short(middle) { low = middle } else { high = middle }
    }
    low
}

/// Splits a vector of friction components into one vector per interface.
fn split(map: &FrictionMap<'_>, frictions: &[f64]) -> Vec<Vec<f64>> {
    let mut each = vec![Vec::new(); map.interfaces()];
    for (owner, friction) in map.owners().zip(frictions) {
        each[owner].push(*friction);
    }
    each
}
