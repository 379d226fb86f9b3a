//! Whether a solution is the only one: a bound, and a search for others.

use super::solution::{Room, UNBOUNDED, greatest};
use super::{Coupled, Coupling, Site};
use crate::dynamics::{most_change_of_load, radius_bound};
use crate::forward::balance::Scene;
use crate::forward::balance::{Balance, Four, Scratch};
use crate::random::Random;
use crate::spatial::{Vec3, Wrench};

/// Starts from which other solutions are looked for.
const STARTS: u32 = 24;
/// Solutions that differ by less than this part are one.
const SAME: f64 = 1e-7;

impl Coupling {
    /// A bound on how strongly friction and loads are coupled: below one there is one solution and no
    /// other (Banach's theorem, as for inverse dynamics).
    pub(in crate::forward) fn strength(&mut self, site: Site<'_>) -> f64 {
        let Scene { parameters, bodies, .. } = site.scene;
        let mut room = std::mem::take(&mut self.room);
        let Room { changes, bounds, .. } = &mut room;
        let count = self.active.len();
        changes.clear();
        for (k, &to) in self.active.iter().enumerate() {
            let content = &parameters.interfaces[to];
            let own = site.affine_frictions[to].own.coefficient;
            let mut rows: [&[Four]; 6] = [&[]; 6];
            rows.iter_mut().zip(self.of_joint(k)).for_each(|(row, of_joint)| *row = of_joint);
            let wrenches = (0..count).map(|l| {
                let [a, b, c, d, e, f] = rows.map(|row| row[l / 4].0[l % 4]);
                Wrench { force: Vec3::new(a, b, c), moment: Vec3::new(d, e, f) }
            });
            let pitch = parameters.pitch[content.joint];
            let most = |wrench| most_change_of_load(content, pitch, bodies, wrench, own);
            changes.extend(wrenches.map(most));
        }
        let bound = radius_bound(changes, count, bounds);
        self.room = room;
        bound
    }

    /// Solutions from many starts, as far as they differ from the given one.
    pub(in crate::forward) fn others(
        &mut self,
        site: Site<'_>,
        balance: &Balance,
        known: &Coupled,
        scratch: &mut Scratch,
    ) -> Vec<Coupled> {
        let mut room = std::mem::take(&mut self.room);
        let mut start = Vec::new();
        self.frictionless_loads(site, &mut start);
        let size = greatest(&start).max(f64::MIN_POSITIVE);
        let mut found: Vec<Coupled> = Vec::new();
        let mut random = Random::new(1);
        for k in 0..STARTS {
            let reach = size * 3f64.powi(k as i32 / 4 + 1);
            let mut loads: Vec<f64> =
                start.iter().map(|_| random.vector().x.abs() * reach).collect();
            let limit = UNBOUNDED * size;
            if !self.newton(site, &mut loads, (1.0, limit), false, &mut room) {
                continue;
            }
            let mut other = Coupled::default();
            self.complete(site, balance, &loads, scratch, &mut other);
            let differs = |a: &Coupled| {
                let largest = a.loads.iter().chain(&other.loads).fold(0.0_f64, |m, x| m.max(*x));
                a.loads.iter().zip(&other.loads).any(|(x, y)| (x - y).abs() > SAME * largest)
            };
            if differs(known) && found.iter().all(differs) {
                found.push(other);
            }
        }
        self.room = room;
        found
    }
}
