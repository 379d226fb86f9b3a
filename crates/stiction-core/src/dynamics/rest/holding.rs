//! Does static friction hold a position while actuators do nothing?
//!
//! Equation (R5) of the book's theory.

use super::map::{FrictionMap, unit};
use super::outer::greatest_frictions;
use crate::linalg::Svd;
use nalgebra::{DMatrix, DVector};

/// What friction does for a position while some actuators do nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Holding {
    /// What is certain.
    pub verdict: Verdict,
    /// The part of all static coefficients that suffices to hold the position: what is certainly
    /// not enough, and what certainly is. Infinite where none was found that suffices.
    pub needed: (f64, f64),
    /// Where it holds: the friction forces that do it, for each contact along its freedoms, with
    /// the sign of the sliding that they act against, N. Empty where it follows from the interval of
    /// the driving force, which contains zero.
    pub frictions: Vec<Vec<f64>>,
}

/// Whether a position is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// There are friction forces within all limits that hold it.
    Holds,
    /// There is a motion in which the load gives more power than friction takes at most.
    Slips,
    /// Neither was shown.
    Undecided,
}

/// Loads that follow the friction: steps of the iteration.
const ROUNDS: usize = 60;
/// Steps of the weighted least squares, and by how much each lessens what rounds off the corners.
const STEPS: usize = 200;
const SHARPEN: f64 = 0.8;
const REFINEMENTS: usize = 3;
/// What is left of the demand is rounding below this part of it.
const MET: f64 = 1e-12;
/// Halvings on the way to the greatest part of the coefficients that does not suffice.
const HALVINGS: usize = 40;
/// The greatest part that is looked at.
const MOST: f64 = 1e6;
/// What is left of unpowered efforts counts as nothing below this part of the largest drive.
const NOTHING: f64 = 1e-10;
/// Bounds that differ by less are one number.
const SAME: f64 = 1e-9;

/// The equations of what must vanish: `slopes * frictions = missing`.
pub(super) struct Demand {
    slopes: DMatrix<f64>,
    missing: DVector<f64>,
}

/// A distribution of the demand over contacts, and a certificate that there is no better one.
struct Share {
    frictions: Vec<f64>,
    /// Every distribution asks some contact for this part of its weight.
    least: f64,
}

impl Demand {
    /// Efforts (with what they are without friction) and idle spins that must vanish.
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
            // An acceleration, in units of what friction makes of it.
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

    /// The same in independent equations; none where no friction at all meets the demand.
    fn independent(&self) -> Option<Self> {
        let svd = Svd::new(&self.slopes.transpose());
        let rank = svd.rank(NOTHING);
        // Combinations of equations that friction has a part in, and those that it has none in.
        let inside = svd.v.columns(0, rank).transpose();
        let outside = svd.v.columns(rank, svd.v.ncols() - rank).transpose();
        let lost = (outside * &self.missing).norm();
        (lost.is_finite() && lost <= NOTHING * self.missing.norm())
            .then(|| Self { slopes: &inside * &self.slopes, missing: inside * &self.missing })
    }

    /// The same by those contacts alone that have a weight; none where they cannot meet the demand.
    fn borne_by(&self, map: &FrictionMap<'_>, weights: &[[f64; 2]]) -> Option<Self> {
        let mut borne = Self { slopes: self.slopes.clone(), missing: self.missing.clone() };
        for (k, owner) in map.owners().enumerate() {
            if weights[owner] == [0.0; 2] {
                borne.slopes.column_mut(k).fill(0.0);
            }
        }
        borne.independent()
    }

    /// Shares the demand so that the largest ratio of a contact's friction to its weight is least:
    /// `min max |f_c| / w_c` under the equations. Its dual is the least power of friction, taken at
    /// the weights, in a motion in which the demand has the power one: a sum of lengths, made least
    /// by weighted least squares, each step of which gives a distribution and a motion.
    ///
    /// Weights are given for friction forward and backward.
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
            // Factors differ by many orders of magnitude in the end: what rounding left is met, too.
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
            // Friction that gives what is missing has the sign of the rate.
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

/// For each contact the one of two numbers, for friction forward and backward, which belongs to the
/// sign of its friction.
fn of_sign(map: &FrictionMap<'_>, frictions: &[f64], numbers: &[[f64; 2]]) -> Vec<f64> {
    let mut chosen: Vec<f64> = numbers.iter().map(|[forward, _]| *forward).collect();
    for (owner, friction) in map.owners().zip(frictions) {
        // Where both are the same, as at balls, the sign does not matter.
        if *friction < 0.0 {
            chosen[owner] = numbers[owner][1];
        }
    }
    chosen
}

/// The largest ratio of a size to its weight.
fn ratio(sizes: &[f64], weights: &[f64]) -> f64 {
    let each = sizes.iter().zip(weights).map(|(&size, &weight)| match size {
        0.0 => 0.0,
        _ if weight > 0.0 => size / weight,
        _ => f64::INFINITY,
    });
    each.fold(0.0, f64::max)
}

/// The limits of frictions under loads, forward and backward.
fn limits(map: &FrictionMap<'_>, loads: &[f64]) -> Vec<[f64; 2]> {
    let limit = |(interface, load): (usize, &f64)| map.coefficients(interface).map(|mu| mu * load);
    loads.iter().enumerate().map(limit).collect()
}

/// Whether friction meets the demand.
pub(super) fn hold(map: &FrictionMap<'_>, demand: &Demand) -> Holding {
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
    let (enough, frictions) = follow_loads(map, &demand);
    let not_enough = greatest_insufficient(map, &demand, enough, &frictions).min(enough);
    let (verdict, frictions) = match (not_enough, enough) {
        (_, enough) if enough <= 1.0 + 1e-12 => (Verdict::Holds, split(map, &frictions)),
        (not_enough, _) if not_enough > 1.0 => (Verdict::Slips, Vec::new()),
        _ => (Verdict::Undecided, Vec::new()),
    };
    // Parts beyond all reason are those of loads that are nothing but rounding.
    let enough = if enough > MOST { f64::INFINITY } else { enough };
    let is_same = enough.is_finite() && enough - not_enough <= SAME * enough;
    let not_enough = if is_same { enough } else { not_enough };
    Holding { verdict, needed: (not_enough, enough), frictions }
}

/// Shares the demand with the loads that it makes itself; the part of the coefficients that the best
/// of them needs. Every one of them is checked by its own loads, so it is attained.
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
        // Half-way: loads that rise and fall in turn settle, too.
        for (weight, own) in weights.iter_mut().zip(own) {
            *weight = [0, 1].map(|way| 0.5 * (weight[way] + own[way]));
        }
    }
    best
}

/// The greatest part of the coefficients, up to `most`, which certainly does not suffice.
///
/// Frictions that meet the demand are one such, `known`, and what has no effect on it. So loads are
/// bounded about `known` as well as about no friction; only directions without effect change them.
fn greatest_insufficient(map: &FrictionMap<'_>, demand: &Demand, most: f64, known: &[f64]) -> f64 {
    let svd = Svd::new(&demand.slopes);
    let rank = svd.rank(NOTHING);
    let reach = svd.v.columns(0, rank);
    let without_effect = |vector: &[f64]| {
        let vector = DVector::from_column_slice(vector);
        let rest = &vector - reach * reach.tr_mul(&vector);
        rest.iter().copied().collect::<Vec<f64>>()
    };
    let plain_loads: Vec<f64> = (0..map.interfaces()).map(|c| map.load_without(c)).collect();
    let plain = map.couplings(|k| unit(map.len(), k));
    let least: Vec<f64> = match known.iter().any(|x| *x != 0.0) {
        true => known.iter().zip(without_effect(known)).map(|(a, b)| a - b).collect(),
        false => svd.solve(&demand.missing, rank).iter().copied().collect(),
    };
    let bound_loads = map.loads(&least);
    let bound = map.couplings(|k| without_effect(&unit(map.len(), k)));
    let falls_short = |part: f64| {
        let frictions = [(&plain_loads, &plain), (&bound_loads, &bound)]
            .map(|(loads, couplings)| greatest_frictions(map, loads, couplings, part));
        let greatest = match frictions {
            [Some(a), Some(b)] => {
                let least = |(a, b): (&[f64; 2], &[f64; 2])| [a[0].min(b[0]), a[1].min(b[1])];
                a.iter().zip(&b).map(least).collect()
            }
            [Some(one), None] | [None, Some(one)] => one,
            [None, None] => return false,
        };
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
        // Parts over many orders of magnitude: the geometric mean, once there is one.
        let middle =
            if low > 0.0 && high > 4.0 * low { (low * high).sqrt() } else { 0.5 * (low + high) };
        if falls_short(middle) { low = middle } else { high = middle }
    }
    low
}

/// The friction of each contact.
fn split(map: &FrictionMap<'_>, frictions: &[f64]) -> Vec<Vec<f64>> {
    let mut each = vec![Vec::new(); map.interfaces()];
    for (owner, friction) in map.owners().zip(frictions) {
        each[owner].push(*friction);
    }
    each
}
