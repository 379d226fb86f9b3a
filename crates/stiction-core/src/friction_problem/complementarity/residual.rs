//! Residual of the friction laws of all members, and its derivatives with respect to the unknowns.

use super::laws::{DryFriction, MemberLaw, SmoothFriction};
use super::problem::Complementarity;
use crate::friction::Load;
use crate::friction_problem::surface_vector::norm;

/// Surface rates below this fraction of the largest frictionless rate count as round-off.
const ROUND_OFF: f64 = 1e-14;

/// Residuals of the friction laws of all members.
pub(super) struct Residual {
    /// Residual of the friction law for each unknown, N.
    pub(super) values: Vec<f64>,
    /// Derivatives of the residual with respect to the multiple of the friction coefficients.
    pub(super) by_part: Vec<f64>,
    /// Largest magnitude among the unknowns, the friction limits and the normal loads of sliding
    /// members, N. Relative residuals refer to this force.
    scale: f64,
    /// For each unknown of a sticking member: [`Complementarity::slack`] times the rate relative to
    /// the largest frictionless rate; infinite for all other unknowns.
    rates: Vec<f64>,
    /// For each dry member the force by which the projection of the [module's](super) equation shortens
    /// its vector, N: positive if the member slides, and otherwise minus the reserve of a member that
    /// sticks. Infinite for other members.
    pub(super) excess: Vec<f64>,
}

impl Residual {
    /// Sum of squares of all residuals.
    pub(super) fn square(&self) -> f64 {
        self.values.iter().map(|x| x * x).sum()
    }

    /// Largest residual relative to the largest force.
    pub(super) fn relative(&self) -> f64 {
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

/// Values of the unknowns for which the friction laws are evaluated, with the resulting rates.
struct Point<'a> {
    x: &'a [f64],
    /// Multiplier of the given friction coefficients; 1 for full friction.
    part: f64,
    rates: Vec<f64>,
    /// Largest magnitude of the surface rates if all members are frictionless.
    largest: f64,
    /// For each dry member, true to require that it sticks, false to require that it slides.
    modes: Option<&'a [bool]>,
}

impl Complementarity<'_> {
    /// Computes the residual with `part` times the friction coefficients; `matrix` receives the
    /// derivatives of the residual (rows) with respect to the unknowns (columns), row by row.
    pub(super) fn residual(&self, x: &[f64], part: f64, matrix: Option<&mut Vec<f64>>) -> Residual {
        self.residual_in_modes(x, (part, None), matrix)
    }

    /// Like [`Self::residual`]; if `modes` are given, the dry members with true must stick whether or
    /// not their friction exceeds the limit, and the others must slide.
    pub(super) fn residual_in_modes(
        &self,
        x: &[f64],
        (part, modes): (f64, Option<&[bool]>),
        mut matrix: Option<&mut Vec<f64>>,
    ) -> Residual {
        let n = self.count();
        let mut rates = self.rates(x);
        // Set round-off of rates to zero, because short time steps would turn it into large forces.
        let largest = self.free.iter().fold(0.0_f64, |m, rate| m.max(rate.abs()));
        rates.iter_mut().filter(|rate| rate.abs() < ROUND_OFF * largest).for_each(|r| *r = 0.0);
        let mut residual = Residual {
            values: vec![0.0; n],
            by_part: vec![0.0; n],
            scale: x.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs())),
            rates: vec![f64::INFINITY; n],
            excess: vec![f64::INFINITY; self.members.len()],
        };
        if let Some(matrix) = matrix.as_deref_mut() {
            matrix.clear();
            matrix.resize(n * n, 0.0);
        }
        let point = Point { x, part, rates, largest, modes };
        for (index, member) in self.members.iter().enumerate() {
            let matrix = matrix.as_deref_mut().map(Vec::as_mut_slice);
            match &member.law {
                MemberLaw::Sliding(_) => {
                    self.evaluate_sliding(&point, index, &mut residual, matrix)
                }
                MemberLaw::Smooth(law) => {
                    self.evaluate_smooth(&point, index, &**law, &mut residual, matrix);
                }
                MemberLaw::Dry(law) => {
                    self.evaluate_dry(&point, index, *law, &mut residual, matrix)
                }
            }
        }
        residual
    }

    fn load_at(&self, point: &Point<'_>, index: usize) -> Load<f64> {
        self.load(index, point.x, self.wrench(index, point.x))
    }

    /// Derivative of the normal load of a member with respect to an unknown.
    fn load_slope(&self, index: usize, load: &Load<f64>, unknown: usize) -> f64 {
        load.gradient.power(self.influence[index * self.count() + unknown])
    }

    fn evaluate_sliding(
        &self,
        point: &Point<'_>,
        index: usize,
        residual: &mut Residual,
        matrix: Option<&mut [f64]>,
    ) {
        let (n, part) = (self.count(), point.part);
        let load = self.load_at(point, index);
        // The unknown is a normal load, and the influence matrix contains the full friction
        // coefficient. The factor `part` therefore multiplies the load.
        let i = self.members[index].places.start;
        residual.scale = residual.scale.max(load.value.abs());
        residual.values[i] = point.x[i] - part * load.value;
        residual.by_part[i] = -load.value;
        let Some(matrix) = matrix else { return };
        for j in 0..n {
            let slope = self.load_slope(index, &load, j);
            matrix[i * n + j] = f64::from(u8::from(i == j)) - part * slope;
        }
    }

    fn evaluate_smooth(
        &self,
        point: &Point<'_>,
        index: usize,
        law: &dyn SmoothFriction,
        residual: &mut Residual,
        matrix: Option<&mut [f64]>,
    ) {
        let (n, part) = (self.count(), point.part);
        let load = self.load_at(point, index);
        let places = self.members[index].places.clone();
        let count = places.len();
        let mut velocity = [0.0; 3];
        velocity[..count].copy_from_slice(&point.rates[places.clone()]);
        let at = |load: f64, v: [f64; 3]| law.friction(load, v).map(|f| part * f);
        let friction = at(load.value, velocity);
        let unit = at(load.value + 1.0, velocity);
        for (k, i) in places.clone().enumerate() {
            residual.values[i] = point.x[i] - friction[k];
            residual.by_part[i] = -friction[k] / part;
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
                    entry -= slope[k][m] * self.compliance[from * n + j];
                }
                entry -= (unit[k] - friction[k]) * self.load_slope(index, &load, j);
                matrix[i * n + j] = entry;
            }
        }
    }

    fn evaluate_dry(
        &self,
        point: &Point<'_>,
        index: usize,
        law: DryFriction,
        residual: &mut Residual,
        matrix: Option<&mut [f64]>,
    ) {
        let n = self.count();
        let Point { x, part, rates, largest, modes } = point;
        let load = self.load_at(point, index);
        let places = self.members[index].places.clone();
        let (viscous, factor) = (law.viscous, self.rate_factor(&places));
        let mut dry = [0.0; 3];
        let mut tried = [0.0; 3];
        for (k, i) in places.clone().enumerate() {
            dry[k] = x[i] - viscous * rates[i];
            tried[k] = dry[k] + factor * rates[i];
        }
        let coefficient = part * law.coefficient(tried[0]);
        let most = coefficient * load.value;
        residual.scale = residual.scale.max(most.abs());
        let size = norm(tried);
        residual.excess[index] = size - most;
        let sticks = modes.map_or(size <= most, |modes| modes[index]);
        for (k, i) in places.clone().enumerate() {
            if sticks && *largest > 0.0 {
                let part = rates[i].abs() / largest;
                residual.rates[i] = if part > 0.0 { self.slack * part } else { 0.0 };
            }
            if !sticks && most > 0.0 {
                residual.by_part[i] = -most / part * tried[k] / size;
            }
            residual.values[i] = if sticks {
                -factor * rates[i]
            } else if most > 0.0 {
                dry[k] - most * tried[k] / size
            } else {
                dry[k]
            };
        }
        let Some(matrix) = matrix else { return };
        for j in 0..n {
            let rate = |i: usize| self.compliance[i * n + j];
            let own = |i: usize| f64::from(u8::from(i == j)) - viscous * rate(i);
            if sticks {
                for i in places.clone() {
                    matrix[i * n + j] = -factor * rate(i);
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
                .map(|(k, i)| tried[k] / size * (own(i) + factor * rate(i)))
                .sum();
            let limit_slope = coefficient * self.load_slope(index, &load, j);
            for (k, i) in places.clone().enumerate() {
                let unit = tried[k] / size;
                let across = own(i) + factor * rate(i) - unit * along;
                matrix[i * n + j] = own(i) - limit_slope * unit - most / size * across;
            }
        }
    }
}
