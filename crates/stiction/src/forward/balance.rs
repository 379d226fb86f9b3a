//! Accelerations and reactions together, for known efforts in the joints.
//!
//! With the tree's mass matrix `M`, what inertia and loads demand `h`, known efforts `f`, and the
//! conditions `J a = r`:
//!
//! ```text
//! M a + h = f + J^T l
//! ```
//!
//! The null space `Z` of `J` splits it: accelerations from `J` and `Z^T M Z`, then multipliers from
//! the independent rows. `M` need not be invertible, only `Z^T M Z`: what moves must weigh something.
//! Dependent rows are redundant constraints: the accelerations do not need them, and their reactions
//! follow from the declared rule ([`super::spread`]).
//!
//! Equations (D1) and (D2) of the book's theory.

use super::masses::Masses;
use super::rows::{Rows, each_freedom};
use super::spread::Spread;
use crate::kinematics::Bodies;
use crate::linalg::RowSpace;
use crate::parameters::Parameters;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::{Link, Role, Topology};

/// Rows that add less than this, relative to the largest, depend on the others: the rule of
/// [`crate::mobility::RANK_TOLERANCE`].
pub(super) const DEPENDENT: f64 = 1e-10;

/// Dependent rows that are missed by more than this part of the largest value contradict the others; less is
/// rounding, and what rates are off by.
const CONTRADICTS: f64 = 1e-6;

/// Something can move without inertia: the body that does so most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Massless {
    pub(super) body: usize,
}

/// Position and velocity as the balance needs them.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) topology: &'a Topology,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) bodies: &'a Bodies<f64>,
    pub(super) masses: &'a Masses,
    /// For each freedom of the tree the characteristic length where it translates, else one.
    pub(super) columns: &'a [f64],
}

/// What answers an effort: all that is linear in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Response {
    /// Of the tree.
    pub(super) accelerations: Vec<f64>,
    /// Of all rows.
    pub(super) multipliers: Vec<f64>,
    /// Each joint's complete wrench, predecessor on successor, about the kernel origin.
    pub(super) wrenches: Vec<Wrench<f64>>,
}

impl Response {
    pub(super) fn add(&mut self, other: &Self, amount: f64) {
        let sum = |a: &mut Vec<f64>, b: &[f64]| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += amount * b);
        };
        sum(&mut self.accelerations, &other.accelerations);
        sum(&mut self.multipliers, &other.multipliers);
        for (a, b) in self.wrenches.iter_mut().zip(&other.wrenches) {
            *a += *b * amount;
        }
    }
}

/// The decomposed balance at one position under one set of conditions.
#[derive(Clone, Debug)]
pub(super) struct Balance {
    pub(super) rows: Rows,
    space: RowSpace,
    /// Orthonormal vectors of scaled accelerations that no row resists, unscaled then.
    basis: Vec<f64>,
    /// The lower triangle of the Cholesky factor of `Z^T M Z`, row by row.
    factor: Vec<f64>,
    /// Spins of single bodies that have no inertia about that axis, as rates of the tree: they keep their rate.
    idle: Vec<Vec<f64>>,
    /// Who bears what where constraints are redundant.
    pub(super) spread: Spread,
}

impl Balance {
    pub(super) fn new(scene: &Scene<'_>, rows: Rows) -> Result<Self, Massless> {
        let n = scene.topology.freedoms();
        let mut scaled = rows.matrix.clone();
        for (row, entries) in rows.rows.iter().zip(scaled.chunks_exact_mut(n.max(1))) {
            for (entry, column) in entries.iter_mut().zip(scene.columns) {
                *entry *= row.scale * column;
            }
        }
        let mut space = RowSpace::default();
        space.decompose(&scaled, rows.rows.len(), n, DEPENDENT);
        let mut basis = space.null_space();
        for vector in basis.chunks_exact_mut(n.max(1)) {
            vector.iter_mut().zip(scene.columns).for_each(|(x, c)| *x *= c);
        }
        let mut idle = Vec::new();
        let may = |rates: &[f64]| moving(scene, rates).1;
        let factor = factor(&scene.masses.matrix, &mut basis, n, &may, &mut idle)
            .map_err(|rates| Massless { body: moving(scene, &rates).0 })?;
        let mut balance = Self { rows, space, basis, factor, idle, spread: Spread::default() };
        balance.pushed(scene, None)?;
        let count = scene.topology.joint_types.len();
        let stresses: Vec<Response> = balance
            .space
            .dependencies()
            .into_iter()
            .map(|scaled| {
                let multipliers = balance.unscale(scaled);
                let still = vec![0.0; n];
                let wrenches = balance.wrenches(scene, &still, &multipliers, &[], false);
                debug_assert!(wrenches.len() == count);
                Response { accelerations: still, multipliers, wrenches }
            })
            .collect();
        balance.spread = Spread::new(scene, &balance.rows, stresses);
        Ok(balance)
    }

    /// Whether nothing acts on spins without inertia: neither what acts on the bodies nor a wrench of a joint.
    ///
    /// # Errors
    /// The spin that something acts on; its acceleration is not defined.
    pub(super) fn pushed(
        &self,
        scene: &Scene<'_>,
        effort: Option<(usize, Wrench<f64>)>,
    ) -> Result<(), Massless> {
        for rates in &self.idle {
            let (mut sum, mut size) = (0.0, 0.0);
            match effort {
                None => {
                    for (rate, bias) in rates.iter().zip(&scene.masses.bias) {
                        sum += rate * bias;
                        size += (rate * bias).abs();
                    }
                    let weight = scene.masses.demand.iter().map(|wrench| wrench.moment.norm());
                    size = weight.fold(size, f64::max);
                }
                Some((joint, wrench)) => {
                    each_freedom(scene.topology, joint, |dof, sign| {
                        sum += sign * scene.bodies.screws[dof].power(wrench) * rates[dof];
                    });
                    size = wrench.moment_about(scene.bodies.frame_j[joint].position).norm();
                }
            }
            if sum.abs() > PUSHED * size {
                return Err(Massless { body: moving(scene, rates).0 });
            }
        }
        Ok(())
    }

    /// Takes from accelerations of the tree what would change the rates of spins without inertia.
    pub(super) fn keep_spins(&self, scene: &Scene<'_>, accelerations: &mut [f64]) {
        let Scene { topology, bodies, .. } = *scene;
        for rates in &self.idle {
            let (body, _) = moving(scene, rates);
            let turn = |amounts: &[f64]| {
                let mut sum = Vec3::zero();
                let mut next = topology.node_of_body[body].map(|node| &topology.nodes[node]);
                while let Some(node) = next {
                    for dof in node.dofs.clone() {
                        sum += bodies.screws[dof].angular * amounts[dof];
                    }
                    next = match node.link {
                        Link::Joint { .. } => node.parent.map(|parent| &topology.nodes[parent]),
                        Link::Floating => None,
                    };
                }
                sum
            };
            let axis = turn(rates);
            let square = axis.norm_squared();
            if square > 0.0 {
                let has = turn(accelerations) + bodies.bias[body].angular;
                let amount = has.dot(axis) / square;
                accelerations.iter_mut().zip(rates).for_each(|(a, rate)| *a -= amount * rate);
            }
        }
    }

    /// How many freedoms are left.
    pub(super) fn mobility(&self, n: usize) -> usize {
        n - self.space.rank()
    }

    /// How far the conditions are from being dependent, between zero and one.
    pub(super) fn distance(&self) -> f64 {
        self.space.least_part()
    }

    /// The row that no acceleration satisfies, if there is one, and by how much the nearest misses it, m/s^2
    /// or rad/s^2: a dependent row whose value is not the one that the others give it.
    pub(super) fn contradiction(&self, scene: &Scene<'_>) -> Option<(usize, f64)> {
        let n = scene.topology.freedoms();
        if self.space.rank() == self.rows.rows.len() {
            return None;
        }
        let right: Vec<f64> = self.rows.rows.iter().map(|r| r.right * r.scale).collect();
        let mut nearest = self.space.shortest(&right);
        nearest.iter_mut().zip(scene.columns).for_each(|(a, c)| *a *= c);
        let each = self.rows.rows.iter().zip(self.rows.matrix.chunks_exact(n.max(1)));
        let missed: Vec<f64> =
            each.map(|(row, entries)| row.scale * (dot(entries, &nearest) - row.right)).collect();
        // Where all values are rounding they are so of terms in the squares of rates.
        let rates =
            scene.bodies.twist.iter().map(|twist| {
                twist.angular.norm().max(twist.linear.norm() / scene.parameters.length)
            });
        let fastest = rates.fold(0.0, f64::max);
        let size = right.iter().fold(fastest * fastest, |m, x| m.max(x.abs()));
        let worst =
            (0..missed.len()).max_by(|a, b| missed[*a].abs().total_cmp(&missed[*b].abs()))?;
        let by = missed[worst].abs();
        (by > CONTRADICTS * size).then(|| (worst, by / self.rows.rows[worst].scale))
    }

    fn unscale(&self, mut multipliers: Vec<f64>) -> Vec<f64> {
        multipliers.iter_mut().zip(&self.rows.rows).for_each(|(m, row)| *m *= row.scale);
        multipliers
    }

    /// The response to wrenches that joints exert beyond their constraints (predecessor on
    /// successor); with all else that acts if `whole`, alone if not.
    pub(super) fn respond(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
    ) -> Response {
        let n = scene.topology.freedoms();
        let bodies = scene.bodies;
        let mut push = vec![0.0; n];
        if whole {
            push.iter_mut().zip(&scene.masses.bias).for_each(|(p, b)| *p = -b);
        }
        for &(joint, wrench) in efforts {
            each_freedom(scene.topology, joint, |dof, sign| {
                push[dof] += sign * bodies.screws[dof].power(wrench);
            });
        }
        let mut accelerations = vec![0.0; n];
        if whole {
            let right: Vec<f64> = self.rows.rows.iter().map(|r| r.right * r.scale).collect();
            accelerations = self.space.shortest(&right);
            accelerations.iter_mut().zip(scene.columns).for_each(|(a, c)| *a *= c);
        }
        // What is left along the freedoms accelerates them.
        let multiply = |x: &[f64], y: &mut [f64]| {
            for (row, y) in scene.masses.matrix.chunks_exact(n.max(1)).zip(y) {
                *y -= row.iter().zip(x).map(|(m, x)| m * x).sum::<f64>();
            }
        };
        if whole {
            multiply(&accelerations, &mut push);
        }
        let free = self.basis.len() / n.max(1);
        let mut along: Vec<f64> =
            self.basis.chunks_exact(n.max(1)).map(|z| dot(z, &push)).collect();
        solve_factored(&self.factor, &mut along, free);
        let mut own = vec![0.0; n];
        for (vector, amount) in self.basis.chunks_exact(n.max(1)).zip(&along) {
            own.iter_mut().zip(vector).for_each(|(a, z)| *a += amount * z);
        }
        multiply(&own, &mut push);
        accelerations.iter_mut().zip(&own).for_each(|(a, o)| *a += o);
        // `M a + h - f`, scaled, lies in what the rows span.
        push.iter_mut().zip(scene.columns).for_each(|(p, c)| *p *= -c);
        let multipliers = self.unscale(self.space.amounts(&push));
        let wrenches = self.wrenches(scene, &accelerations, &multipliers, efforts, whole);
        let mut response = Response { accelerations, multipliers, wrenches };
        self.spread.apply(scene, &self.rows, whole, &mut response);
        response
    }

    fn wrenches(
        &self,
        scene: &Scene<'_>,
        accelerations: &[f64],
        multipliers: &[f64],
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
    ) -> Vec<Wrench<f64>> {
        let Scene { topology, bodies, masses, .. } = *scene;
        let mut beyond =
            if whole { masses.demand.clone() } else { vec![Wrench::zero(); bodies.pose.len()] };
        let mut sums = vec![Twist::zero(); bodies.pose.len()];
        for node in &topology.nodes {
            let mut sum = match (node.link, node.parent) {
                (Link::Joint { .. }, Some(parent)) => sums[topology.nodes[parent].body],
                _ => Twist::zero(),
            };
            for dof in node.dofs.clone() {
                sum += bodies.screws[dof] * accelerations[dof];
            }
            sums[node.body] = sum;
            beyond[node.body] += masses.inertia[node.body].times(sum);
        }
        let mut wrenches = vec![Wrench::zero(); topology.joint_types.len()];
        let in_cuts = |joint: usize| matches!(topology.role[joint], Role::Cut { .. });
        for (row, multiplier) in self.rows.rows.iter().zip(multipliers) {
            if in_cuts(row.joint) {
                wrenches[row.joint] += row.covector * *multiplier;
            }
        }
        for &(joint, wrench) in efforts {
            if in_cuts(joint) {
                wrenches[joint] += wrench;
            }
        }
        for cut in &topology.cuts {
            let (predecessor, successor) = topology.ends[cut.joint];
            beyond[successor] -= wrenches[cut.joint];
            beyond[predecessor] += wrenches[cut.joint];
        }
        for node in topology.nodes.iter().rev() {
            let Link::Joint { joint, reversed } = node.link else { continue };
            let wrench = beyond[node.body];
            wrenches[joint] = if reversed { -wrench } else { wrench };
            if let Some(parent) = node.parent {
                beyond[topology.nodes[parent].body] += wrench;
            }
        }
        wrenches
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The body that rates of the tree move most, and whether they turn it and leave all others alone: a rod between
/// two balls about itself.
fn moving(scene: &Scene<'_>, rates: &[f64]) -> (usize, bool) {
    let Scene { topology, bodies, parameters, .. } = *scene;
    let mut twists = vec![Twist::zero(); bodies.pose.len()];
    for node in &topology.nodes {
        let mut sum = match (node.link, node.parent) {
            (Link::Joint { .. }, Some(parent)) => twists[topology.nodes[parent].body],
            _ => Twist::zero(),
        };
        for dof in node.dofs.clone() {
            sum += bodies.screws[dof] * rates[dof];
        }
        twists[node.body] = sum;
    }
    let size =
        |twist: &Twist<f64>| twist.angular.norm().max(twist.linear.norm() / parameters.length);
    let fastest = (0..twists.len()).max_by(|a, b| size(&twists[*a]).total_cmp(&size(&twists[*b])));
    let Some(fastest) = fastest else { return (0, false) };
    let least = ALONE * size(&twists[fastest]);
    let turns = twists[fastest].angular.norm() > least;
    let alone = twists.iter().filter(|twist| size(twist) > least).count() == 1;
    (fastest, turns && alone)
}

/// Cholesky's factor of `Z^T M Z`, the vectors of `basis` put in an order in which what moves without inertia comes
/// last: without it small pivots on the way would hide it in rounding. Motions without inertia that `may` be are put
/// into `idle` and given some: what does not act on them does not move them then.
///
/// # Errors
/// The rates of a motion without inertia that may not be.
pub(super) fn factor(
    matrix: &[f64],
    basis: &mut [f64],
    n: usize,
    may: &dyn Fn(&[f64]) -> bool,
    idle: &mut Vec<Vec<f64>>,
) -> Result<Vec<f64>, Vec<f64>> {
    let n = n.max(1);
    let free = basis.len() / n;
    let mut factor = vec![0.0; free * free];
    for (i, z) in basis.chunks_exact(n).enumerate() {
        let moved: Vec<f64> = matrix.chunks_exact(n).map(|row| dot(row, z)).collect();
        for (j, other) in basis.chunks_exact(n).enumerate().skip(i) {
            let entry = dot(&moved, other);
            factor[j * free + i] = entry;
            factor[i * free + j] = entry;
        }
    }
    let largest = (0..free).map(|i| factor[i * free + i]).fold(0.0, f64::max);
    for i in 0..free {
        let heaviest = (i..free).max_by(|a, b| {
            let rest = |k: &usize| factor[k * free + k];
            rest(a).total_cmp(&rest(b))
        });
        if let Some(other) = heaviest.filter(|k| *k != i) {
            for k in 0..free {
                factor.swap(i * free + k, other * free + k);
            }
            for k in i..free {
                factor.swap(k * free + i, k * free + other);
            }
            for k in 0..n {
                basis.swap(i * n + k, other * n + k);
            }
        }
        let rest = factor[i * free + i];
        if rest > NOTHING * largest {
            let root = rest.sqrt();
            factor[i * free + i] = root;
            for j in i + 1..free {
                factor[j * free + i] /= root;
            }
            for j in i + 1..free {
                let own = factor[j * free + i];
                for k in i + 1..=j {
                    let entry = factor[j * free + k] - own * factor[k * free + i];
                    factor[j * free + k] = entry;
                    factor[k * free + j] = entry;
                }
            }
            continue;
        }
        // The motion itself: this vector less what those before must do along with it.
        let mut with: Vec<f64> = (0..i).map(|k| factor[i * free + k]).collect();
        for k in (0..i).rev() {
            let after: f64 = (k + 1..i).map(|m| factor[m * free + k] * with[m]).sum();
            with[k] = (with[k] - after) / factor[k * free + k];
        }
        let mut rates = basis[i * n..(i + 1) * n].to_vec();
        for (vector, amount) in basis.chunks_exact(n).zip(&with) {
            rates.iter_mut().zip(vector).for_each(|(r, z)| *r -= amount * z);
        }
        if !may(&rates) {
            return Err(rates);
        }
        idle.push(rates);
        factor[i * free + i] = if largest > 0.0 { largest.sqrt() } else { 1.0 };
        for j in i + 1..free {
            factor[j * free + i] = 0.0;
        }
    }
    Ok(factor)
}

/// Moments about a spin without inertia below this part of their size are none: inertia below [`NOTHING`] leaves its
/// axis uncertain by the root of that.
const PUSHED: f64 = 1e-6;
/// Bodies slower than this part of the fastest stand.
const ALONE: f64 = 1e-6;

/// Inertia along a freedom below this part of the largest is rounding.
const NOTHING: f64 = 1e-14;

pub(super) fn solve_factored(factor: &[f64], right: &mut [f64], free: usize) {
    for i in 0..free {
        let sum: f64 = (0..i).map(|k| factor[i * free + k] * right[k]).sum();
        right[i] = (right[i] - sum) / factor[i * free + i];
    }
    for i in (0..free).rev() {
        let sum: f64 = (i + 1..free).map(|k| factor[k * free + i] * right[k]).sum();
        right[i] = (right[i] - sum) / factor[i * free + i];
    }
}
