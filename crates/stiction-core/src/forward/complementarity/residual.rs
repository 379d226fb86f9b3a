//! By how much the laws of all members are missed, and how that changes with the unknowns.

use super::laws::{Dry, Kind, Smooth};
use super::problem::Cone;
use crate::forward::affine_friction::norm;
use crate::friction::Load;

/// Rates below this part of the largest without friction are rounding.
const ROUNDING: f64 = 1e-14;

/// How the laws are missed.
pub(super) struct Residual {
    /// Of each unknown, N.
    pub(super) values: Vec<f64>,
    /// The largest force, N.
    scale: f64,
    /// The rates of what holds as part of the largest, times the slack; of all else infinite.
    rates: Vec<f64>,
    /// Whether each member holds.
    pub(super) holds: Vec<bool>,
}

impl Residual {
    pub(super) fn square(&self) -> f64 {
        self.values.iter().map(|x| x * x).sum()
    }

    /// The worst of them as part of the largest force.
    pub(super) fn missed(&self) -> f64 {
        let each = self.values.iter().zip(&self.rates);
        let worst = each.fold(0.0_f64, |m, (x, rate)| m.max(x.abs().min(rate * self.scale)));
        let sound = self.values.iter().all(|x| x.is_finite()) && self.scale.is_finite();
        if !sound {
            f64::INFINITY
        } else if worst == 0.0 {
            0.0
        } else {
            worst / self.scale
        }
    }
}

/// Where the laws are looked at.
struct Place<'a> {
    x: &'a [f64],
    /// What coefficients of friction are multiplied by.
    part: f64,
    rates: Vec<f64>,
    /// The largest rate where none of the unknowns acts.
    largest: f64,
}

impl Cone<'_> {
    /// How the laws are missed, coefficients of friction being `part` of their values; `matrix` becomes how that
    /// changes with the unknowns, row by row.
    pub(super) fn residual(
        &self,
        x: &[f64],
        part: f64,
        mut matrix: Option<&mut Vec<f64>>,
    ) -> Residual {
        let n = self.count();
        let mut rates = self.rates(x);
        // Rates that are rounding are none: short steps would make large forces of them.
        let largest = self.free.iter().fold(0.0_f64, |m, rate| m.max(rate.abs()));
        rates.iter_mut().filter(|rate| rate.abs() < ROUNDING * largest).for_each(|r| *r = 0.0);
        let mut residual = Residual {
            values: vec![0.0; n],
            scale: x.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs())),
            rates: vec![f64::INFINITY; n],
            holds: vec![false; self.members.len()],
        };
        if let Some(matrix) = matrix.as_deref_mut() {
            matrix.clear();
            matrix.resize(n * n, 0.0);
        }
        let place = Place { x, part, rates, largest };
        for (index, member) in self.members.iter().enumerate() {
            let matrix = matrix.as_deref_mut().map(Vec::as_mut_slice);
            match &member.kind {
                Kind::Slides(_) => self.look_at_sliding(&place, index, &mut residual, matrix),
                Kind::Smooth(law) => {
                    self.look_at_smooth(&place, index, &**law, &mut residual, matrix);
                }
                Kind::Dry(law) => self.look_at_dry(&place, index, *law, &mut residual, matrix),
            }
        }
        residual
    }

    fn load_at(&self, place: &Place<'_>, index: usize) -> Load<f64> {
        self.load(index, place.x, self.wrench(index, place.x))
    }

    /// How a member's load changes with an unknown.
    fn load_grows(&self, index: usize, load: &Load<f64>, unknown: usize) -> f64 {
        load.gradient.power(self.push[index * self.count() + unknown])
    }

    fn look_at_sliding(
        &self,
        place: &Place<'_>,
        index: usize,
        residual: &mut Residual,
        matrix: Option<&mut [f64]>,
    ) {
        let (n, part) = (self.count(), place.part);
        let load = self.load_at(place, index);
        // Its unit is that of the full coefficient.
        let i = self.members[index].places.start;
        residual.scale = residual.scale.max(load.value.abs());
        residual.values[i] = place.x[i] - part * load.value;
        let Some(matrix) = matrix else { return };
        for j in 0..n {
            let grows = self.load_grows(index, &load, j);
            matrix[i * n + j] = f64::from(u8::from(i == j)) - part * grows;
        }
    }

    fn look_at_smooth(
        &self,
        place: &Place<'_>,
        index: usize,
        law: &dyn Smooth,
        residual: &mut Residual,
        matrix: Option<&mut [f64]>,
    ) {
        let (n, part) = (self.count(), place.part);
        let load = self.load_at(place, index);
        let places = self.members[index].places.clone();
        let count = places.len();
        let mut velocity = [0.0; 3];
        velocity[..count].copy_from_slice(&place.rates[places.clone()]);
        let at = |load: f64, v: [f64; 3]| law.friction(load, v).map(|f| part * f);
        let friction = at(load.value, velocity);
        let unit = at(load.value + 1.0, velocity);
        for (k, i) in places.clone().enumerate() {
            residual.values[i] = place.x[i] - friction[k];
        }
        let Some(matrix) = matrix else { return };
        let step = 1e-7 * norm(velocity).max(1e-6);
        let mut slope = [[0.0; 3]; 3];
        for m in 0..count {
            let (mut ahead, mut behind) = (velocity, velocity);
            ahead[m] += step;
            behind[m] -= step;
            let (ahead, behind) = (at(load.value, ahead), at(load.value, behind));
            for k in 0..count {
                slope[k][m] = (ahead[k] - behind[k]) / (2.0 * step);
            }
        }
        for (k, i) in places.clone().enumerate() {
            for j in 0..n {
                let mut entry = f64::from(u8::from(i == j));
                for (m, from) in places.clone().enumerate() {
                    entry -= slope[k][m] * self.change[from * n + j];
                }
                entry -= (unit[k] - friction[k]) * self.load_grows(index, &load, j);
                matrix[i * n + j] = entry;
            }
        }
    }

    fn look_at_dry(
        &self,
        place: &Place<'_>,
        index: usize,
        law: Dry,
        residual: &mut Residual,
        matrix: Option<&mut [f64]>,
    ) {
        let n = self.count();
        let Place { x, part, rates, largest } = place;
        let load = self.load_at(place, index);
        let places = self.members[index].places.clone();
        let (viscous, softness) = (law.viscous, self.softness(&places));
        let mut dry = [0.0; 3];
        let mut tried = [0.0; 3];
        for (k, i) in places.clone().enumerate() {
            dry[k] = x[i] - viscous * rates[i];
            tried[k] = dry[k] + softness * rates[i];
        }
        let coefficient = part * law.coefficient(tried[0]);
        let most = coefficient * load.value;
        residual.scale = residual.scale.max(most.abs());
        let size = norm(tried);
        let holds = size <= most;
        residual.holds[index] = holds;
        for (k, i) in places.clone().enumerate() {
            if holds && *largest > 0.0 {
                let part = rates[i].abs() / largest;
                residual.rates[i] = if part > 0.0 { self.slack * part } else { 0.0 };
            }
            residual.values[i] = if holds {
                -softness * rates[i]
            } else if most > 0.0 {
                dry[k] - most * tried[k] / size
            } else {
                dry[k]
            };
        }
        let Some(matrix) = matrix else { return };
        for j in 0..n {
            let rate = |i: usize| self.change[i * n + j];
            let own = |i: usize| f64::from(u8::from(i == j)) - viscous * rate(i);
            if holds {
                for i in places.clone() {
                    matrix[i * n + j] = -softness * rate(i);
                }
                continue;
            }
            if most <= 0.0 {
                for i in places.clone() {
                    matrix[i * n + j] = own(i);
                }
                continue;
            }
            let along: f64 = places
                .clone()
                .enumerate()
                .map(|(k, i)| tried[k] / size * (own(i) + softness * rate(i)))
                .sum();
            let grows = coefficient * self.load_grows(index, &load, j);
            for (k, i) in places.clone().enumerate() {
                let unit = tried[k] / size;
                let across = own(i) + softness * rate(i) - unit * along;
                matrix[i * n + j] = own(i) - grows * unit - most / size * across;
            }
        }
    }
}
