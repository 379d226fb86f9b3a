//! Projected Gauss-Seidel method: solves the friction law of one interface at a time.

use super::SETTLED;
use super::laws::{DryFriction, MemberLaw, SmoothFriction};
use super::local::{LocalResponse, smooth_friction};
use super::problem::Complementarity;
use crate::friction_problem::surface_vector::norm;
use crate::spatial::Wrench;
use nalgebra::Vector3;
use std::ops::Range;

/// Data from which the friction law of one member is evaluated.
struct View<'a> {
    /// Indices of the member's unknowns among the unknowns of all members.
    places: Range<usize>,
    x: &'a [f64],
    rates: &'a [f64],
    load: f64,
    /// Multiplier of the given friction coefficients; 1 for full friction.
    part: f64,
    /// Factor that scales the member's rates to the magnitude of forces.
    factor: f64,
}

impl Complementarity<'_> {
    /// Solves the friction law of each member in turn, with `part` times the friction coefficients,
    /// and updates the rates and wrenches of all members after each solution. Makes at most
    /// `sweeps` passes over the members. `x` contains the unknowns: the initial guess, then the
    /// result.
    pub(super) fn project(&self, x: &mut [f64], part: f64, sweeps: usize) {
        let n = self.count();
        let mut rates = self.rates(x);
        let mut wrenches: Vec<Wrench<f64>> =
            (0..self.members.len()).map(|m| self.wrench(m, x)).collect();
        for _ in 0..sweeps {
            let mut change = 0.0_f64;
            for (index, member) in self.members.iter().enumerate() {
                let places = member.places.clone();
                let load = self.load(index, x, wrenches[index]).value;
                let factor = self.rate_factor(&places);
                let view = View { places: places.clone(), x, rates: &rates, load, part, factor };
                let next = match (&member.law, &self.local[index]) {
                    (MemberLaw::Sliding(_), _) => [part * load, 0.0, 0.0],
                    (MemberLaw::Dry(law), Some(local)) => self.coupled_friction(local, *law, &view),
                    (MemberLaw::Dry(law), None) => projected_friction(*law, &view),
                    (MemberLaw::Smooth(law), _) => smooth_friction_from(&**law, &view),
                };
                for (k, i) in places.enumerate() {
                    let change_here = next[k] - x[i];
                    if change_here == 0.0 {
                        continue;
                    }
                    x[i] = next[k];
                    change = change.max(change_here.abs());
                    for (rate, row) in rates.iter_mut().zip(self.compliance.chunks_exact(n)) {
                        *rate += row[i] * change_here;
                    }
                    for (wrench, row) in wrenches.iter_mut().zip(self.influence.chunks_exact(n)) {
                        *wrench += row[i] * change_here;
                    }
                }
            }
            let largest = x.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
            if change <= 1e-3 * SETTLED * largest || !change.is_finite() {
                break;
            }
        }
    }

    /// Computes the dry and viscous friction of a ball or plate, N. Solves for all components
    /// together, because the effective masses in different directions may differ by orders of
    /// magnitude.
    fn coupled_friction(
        &self,
        local: &LocalResponse,
        law: DryFriction,
        view: &View<'_>,
    ) -> [f64; 3] {
        let View { places, x, rates, load, part, .. } = view;
        let (n, DryFriction { forward, viscous, .. }) = (self.count(), law);
        let (mut free, mut before) = ([0.0; 3], [0.0; 3]);
        for (k, i) in places.clone().enumerate() {
            free[k] = rates[i];
            for j in places.clone() {
                free[k] -= self.compliance[i * n + j] * x[j];
            }
            before[k] = x[i] - viscous * rates[i];
        }
        let most = (part * forward * load).max(0.0);
        let dry = local.dry_friction(free, most, viscous, before);
        // The rate is `(1 + viscous W)^-1 (free - W dry)` with the negated compliance `W` of the
        // member.
        let vectors = &local.vectors;
        let (free, dry) = (Vector3::from(free), Vector3::from(dry));
        let (f, d) = (vectors.transpose() * free, vectors.transpose() * dry);
        let rate = Vector3::from_fn(|k, _| {
            let w = local.values[k];
            (f[k] - w * d[k]) / (1.0 + viscous * w)
        });
        (dry + vectors * rate * viscous).into()
    }
}

/// Computes the friction of a member with one component, N: projects dry friction onto the friction
/// limit at the present normal load, then adds viscous friction.
fn projected_friction(law: DryFriction, view: &View<'_>) -> [f64; 3] {
    let View { places, x, rates, load, part, factor } = view;
    let viscous = law.viscous;
    let total = factor + viscous;
    let mut next = [0.0; 3];
    for (k, i) in places.clone().enumerate() {
        next[k] = x[i] - viscous * rates[i] + total * rates[i];
    }
    let coefficient = part * law.coefficient(next[0]);
    let most = (coefficient * load).max(0.0);
    let size = norm(next);
    if size > most {
        next = next.map(|f| f * (most / size));
    }
    if viscous > 0.0 && *factor > 0.0 {
        for (k, i) in places.clone().enumerate() {
            // Rate without the member's own friction.
            let free = rates[i] + x[i] / factor;
            let rate = (free - next[k] / factor) / (1.0 + viscous / factor);
            next[k] += viscous * rate;
        }
    }
    next
}

fn smooth_friction_from(law: &dyn SmoothFriction, view: &View<'_>) -> [f64; 3] {
    let View { places, x, rates, load, part, factor } = view;
    let (mut free, mut velocity) = ([0.0; 3], [0.0; 3]);
    for (k, i) in places.clone().enumerate() {
        velocity[k] = rates[i];
        free[k] = rates[i] + if *factor > 0.0 { x[i] / factor } else { 0.0 };
    }
    smooth_friction(law, part * load.max(0.0), free, *factor, velocity, places.len())
}
