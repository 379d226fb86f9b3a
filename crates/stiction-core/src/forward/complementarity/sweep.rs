//! Contact by contact: projected Gauss-Seidel.

use super::SETTLED;
use super::alone::{Alone, settle_smooth};
use super::laws::{Dry, Kind, Smooth};
use super::problem::Cone;
use crate::forward::affine_friction::norm;
use crate::spatial::Wrench;
use nalgebra::Vector3;
use std::ops::Range;

/// What a member meets when it is its turn.
struct Turn<'a> {
    /// Its unknowns.
    places: Range<usize>,
    x: &'a [f64],
    rates: &'a [f64],
    load: f64,
    /// What coefficients of friction are multiplied by.
    part: f64,
    /// What its rates are multiplied by, for numbers of the size of forces.
    softness: f64,
}

impl Cone<'_> {
    /// Contact by contact, the rates and loads following.
    pub(super) fn sweep(&self, x: &mut [f64], part: f64, sweeps: usize) {
        let n = self.count();
        let mut rates = self.rates(x);
        let mut wrenches: Vec<Wrench<f64>> =
            (0..self.members.len()).map(|m| self.wrench(m, x)).collect();
        for _ in 0..sweeps {
            let mut change = 0.0_f64;
            for (index, member) in self.members.iter().enumerate() {
                let places = member.places.clone();
                let load = self.load(index, x, wrenches[index]).value;
                let softness = self.softness(&places);
                let turn = Turn { places: places.clone(), x, rates: &rates, load, part, softness };
                let next = match (&member.kind, &self.alone[index]) {
                    (Kind::Slides(_), _) => [part * load, 0.0, 0.0],
                    (Kind::Dry(law), Some(alone)) => self.settle_together(alone, *law, &turn),
                    (Kind::Dry(law), None) => settle_dry(*law, &turn),
                    (Kind::Smooth(law), _) => settle_smooth_from(&**law, &turn),
                };
                for (k, i) in places.enumerate() {
                    let by = next[k] - x[i];
                    if by == 0.0 {
                        continue;
                    }
                    x[i] = next[k];
                    change = change.max(by.abs());
                    for (rate, row) in rates.iter_mut().zip(self.change.chunks_exact(n)) {
                        *rate += row[i] * by;
                    }
                    for (wrench, push) in wrenches.iter_mut().zip(self.push.chunks_exact(n)) {
                        *wrench += push[i] * by;
                    }
                }
            }
            let largest = x.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            if change <= 1e-3 * SETTLED * largest || !change.is_finite() {
                break;
            }
        }
    }

    /// All components of a ball or plate at once: inertias may differ by orders of magnitude.
    fn settle_together(&self, alone: &Alone, law: Dry, turn: &Turn<'_>) -> [f64; 3] {
        let Turn { places, x, rates, load, part, .. } = turn;
        let (n, Dry { forward, viscous, .. }) = (self.count(), law);
        let (mut free, mut before) = ([0.0; 3], [0.0; 3]);
        for (k, i) in places.clone().enumerate() {
            free[k] = rates[i];
            for j in places.clone() {
                free[k] -= self.change[i * n + j] * x[j];
            }
            before[k] = x[i] - viscous * rates[i];
        }
        let most = (part * forward * load).max(0.0);
        let dry = alone.settle(free, most, viscous, before);
        // `rate = (1 + viscous W)^-1 (free - W dry)`.
        let vectors = &alone.vectors;
        let (free, dry) = (Vector3::from(free), Vector3::from(dry));
        let (f, d) = (vectors.transpose() * free, vectors.transpose() * dry);
        let rate = Vector3::from_fn(|k, _| {
            let w = alone.values[k];
            (f[k] - w * d[k]) / (1.0 + viscous * w)
        });
        (dry + vectors * rate * viscous).into()
    }
}

/// Dry friction that its own softness projects onto what its load bounds.
fn settle_dry(law: Dry, turn: &Turn<'_>) -> [f64; 3] {
    let Turn { places, x, rates, load, part, softness } = turn;
    let viscous = law.viscous;
    let more = softness + viscous;
    let mut next = [0.0; 3];
    for (k, i) in places.clone().enumerate() {
        next[k] = x[i] - viscous * rates[i] + more * rates[i];
    }
    let coefficient = part * law.coefficient(next[0]);
    let most = (coefficient * load).max(0.0);
    let size = norm(next);
    if size > most {
        next = next.map(|f| f * (most / size));
    }
    if viscous > 0.0 && *softness > 0.0 {
        for (k, i) in places.clone().enumerate() {
            // Where none of its friction acts the rate is this.
            let free = rates[i] + x[i] / softness;
            let rate = (free - next[k] / softness) / (1.0 + viscous / softness);
            next[k] += viscous * rate;
        }
    }
    next
}

fn settle_smooth_from(law: &dyn Smooth, turn: &Turn<'_>) -> [f64; 3] {
    let Turn { places, x, rates, load, part, softness } = turn;
    let (mut free, mut velocity) = ([0.0; 3], [0.0; 3]);
    for (k, i) in places.clone().enumerate() {
        velocity[k] = rates[i];
        free[k] = rates[i] + if *softness > 0.0 { x[i] / softness } else { 0.0 };
    }
    settle_smooth(law, part * load.max(0.0), free, *softness, velocity, places.len())
}
