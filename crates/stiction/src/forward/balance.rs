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

use super::masses::{Masses, lift_twist, lift_wrench};
use super::rows::{Rows, each_freedom};
use super::spread::Spread;
use crate::kinematics::Bodies;
use crate::linalg::RowSpace;
use crate::parameters::Parameters;
use crate::scalar::{Lanes, Scalar};
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
#[derive(Debug, Default)]
pub(super) struct Response {
    /// Of the tree.
    pub(super) accelerations: Vec<f64>,
    /// Of all rows.
    pub(super) multipliers: Vec<f64>,
    /// Each joint's complete wrench, predecessor on successor, about the kernel origin.
    pub(super) wrenches: Vec<Wrench<f64>>,
}

impl Clone for Response {
    fn clone(&self) -> Self {
        let Self { accelerations, multipliers, wrenches } = self;
        Self {
            accelerations: accelerations.clone(),
            multipliers: multipliers.clone(),
            wrenches: wrenches.clone(),
        }
    }

    /// Into the room that is there.
    fn clone_from(&mut self, other: &Self) {
        self.accelerations.clone_from(&other.accelerations);
        self.multipliers.clone_from(&other.multipliers);
        self.wrenches.clone_from(&other.wrenches);
    }
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

/// Numbers of four responses at once.
pub(super) type Four = Lanes<f64, 4>;

/// What answers efforts, and room for it.
#[derive(Clone, Debug)]
struct Answer<T> {
    /// What drives the tree's freedoms; then what is left of it.
    push: Vec<T>,
    along: Vec<T>,
    accelerations: Vec<T>,
    multipliers: Vec<T>,
    sums: Vec<Twist<T>>,
    /// What joints must exert on each body.
    beyond: Vec<Wrench<T>>,
    wrenches: Vec<Wrench<T>>,
}

impl<T> Default for Answer<T> {
    fn default() -> Self {
        Self {
            push: Vec::new(),
            along: Vec::new(),
            accelerations: Vec::new(),
            multipliers: Vec::new(),
            sums: Vec::new(),
            beyond: Vec::new(),
            wrenches: Vec::new(),
        }
    }
}

/// Room for one response after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    right: Vec<f64>,
    one: Answer<f64>,
    four: Answer<Four>,
    /// Also for the rule of shares.
    spread: super::spread::Room,
}

/// The decomposed balance at one position under one set of conditions.
#[derive(Clone, Debug, Default)]
pub(super) struct Balance {
    pub(super) rows: Rows,
    space: RowSpace,
    scaled: Vec<f64>,
    /// Orthonormal vectors of scaled accelerations that no row resists, unscaled then.
    basis: Vec<f64>,
    /// The momentum of each of these.
    moved: Vec<f64>,
    /// The lower triangle of the Cholesky factor of `Z^T M Z`, row by row.
    factor: Vec<f64>,
    /// Spins of single bodies that have no inertia about that axis, as rates of the tree: they keep their rate.
    idle: Vec<Vec<f64>>,
    /// Who bears what where constraints are redundant.
    pub(super) spread: Spread,
}

impl Balance {
    pub(super) fn new(scene: &Scene<'_>, rows: Rows) -> Result<Self, Massless> {
        let mut balance = Self { rows, ..Self::default() };
        balance.update(scene, &mut Scratch::default())?;
        Ok(balance)
    }

    /// Decomposes anew for its rows, in the room that is there.
    pub(super) fn update(
        &mut self,
        scene: &Scene<'_>,
        scratch: &mut Scratch,
    ) -> Result<(), Massless> {
        let n = scene.topology.freedoms();
        let Self { rows, space, scaled, basis, moved, factor, idle, .. } = self;
        scaled.clone_from(&rows.matrix);
        for (row, entries) in rows.rows.iter().zip(scaled.chunks_exact_mut(n.max(1))) {
            for (entry, column) in entries.iter_mut().zip(scene.columns) {
                *entry *= row.scale * column;
            }
        }
        space.decompose(scaled, rows.rows.len(), n, DEPENDENT);
        space.null_space_into(basis);
        for vector in basis.chunks_exact_mut(n.max(1)) {
            vector.iter_mut().zip(scene.columns).for_each(|(x, c)| *x *= c);
        }
        idle.clear();
        let may = |rates: &[f64]| moving(scene, rates).1;
        factorise(&scene.masses.matrix, basis, n, &may, (idle, moved, factor))
            .map_err(|rates| Massless { body: moving(scene, &rates).0 })?;
        self.pushed(scene, None)?;
        let Self { rows, space, spread, .. } = self;
        if rows.rows.len() == space.rank() {
            if !spread.stresses.is_empty() {
                *spread = Spread::default();
            }
            return Ok(());
        }
        let dependencies = self.space.dependencies();
        let mut stresses = Vec::with_capacity(dependencies.len());
        for mut multipliers in dependencies {
            multipliers.iter_mut().zip(&self.rows.rows).for_each(|(m, row)| *m *= row.scale);
            let one = &mut scratch.one;
            fill(&mut one.accelerations, n, 0.0);
            fill(&mut one.beyond, scene.bodies.pose.len(), Wrench::zero());
            one.multipliers.clone_from(&multipliers);
            self.load_joints(scene, &[], one);
            let accelerations = vec![0.0; n];
            stresses.push(Response { accelerations, multipliers, wrenches: one.wrenches.clone() });
        }
        self.spread = Spread::new(scene, &self.rows, stresses);
        Ok(())
    }

    /// Whether there are spins without inertia.
    pub(super) fn has_idle(&self) -> bool {
        !self.idle.is_empty()
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

    /// The response to wrenches that joints exert beyond their constraints (predecessor on
    /// successor); with all else that acts if `whole`, alone if not.
    pub(super) fn respond(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
    ) -> Response {
        let mut response = Response::default();
        self.respond_into(scene, efforts, whole, &mut Scratch::default(), &mut response);
        response
    }

    /// The same in the room that is there.
    pub(super) fn respond_into(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
        scratch: &mut Scratch,
        response: &mut Response,
    ) {
        let n = scene.topology.freedoms();
        let Scratch { right, one, spread, .. } = scratch;
        fill(&mut one.push, n, 0.0);
        if whole {
            one.push.iter_mut().zip(&scene.masses.bias).for_each(|(p, b)| *p = -b);
            one.beyond.clone_from(&scene.masses.demand);
            right.clear();
            right.extend(self.rows.rows.iter().map(|r| r.right * r.scale));
            self.space.shortest_into(right, &mut one.accelerations);
            one.accelerations.iter_mut().zip(scene.columns).for_each(|(a, c)| *a *= c);
            for (row, push) in scene.masses.matrix.chunks_exact(n.max(1)).zip(&mut one.push) {
                *push -= dot(row, &one.accelerations);
            }
        } else {
            fill(&mut one.beyond, scene.bodies.pose.len(), Wrench::zero());
            fill(&mut one.accelerations, n, 0.0);
        }
        for &(joint, wrench) in efforts {
            each_freedom(scene.topology, joint, |dof, sign| {
                one.push[dof] += sign * scene.bodies.screws[dof].power(wrench);
            });
        }
        self.answer(scene, efforts, one);
        response.accelerations.clone_from(&one.accelerations);
        response.multipliers.clone_from(&one.multipliers);
        response.wrenches.clone_from(&one.wrenches);
        self.spread.apply(scene, &self.rows, whole, spread, response);
    }

    /// The wrenches of all joints under up to four efforts, each alone; only where nothing is redundant.
    pub(super) fn respond_to_four<'s>(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        scratch: &'s mut Scratch,
    ) -> &'s [Wrench<Four>] {
        debug_assert!(self.spread.stresses.is_empty(), "shares are open");
        let n = scene.topology.freedoms();
        let four = &mut scratch.four;
        fill(&mut four.push, n, Four::zero());
        fill(&mut four.accelerations, n, Four::zero());
        fill(&mut four.beyond, scene.bodies.pose.len(), Wrench::zero());
        let mut lanes = [(0, Wrench::zero()); 4];
        for (k, (&(joint, effort), lane)) in efforts.iter().zip(&mut lanes).enumerate() {
            let only = Four::from_fn(|l| if l == k { 1.0 } else { 0.0 });
            *lane = (joint, lift_wrench::<Four>(effort) * only);
            each_freedom(scene.topology, joint, |dof, sign| {
                four.push[dof].0[k] += sign * scene.bodies.screws[dof].power(effort);
            });
        }
        self.answer(scene, &lanes[..efforts.len().min(4)], four);
        &four.wrenches
    }

    /// What follows from accelerations that satisfy the rows, from what drives the freedoms beyond them, efforts
    /// included, and from what joints must exert on each body where nothing accelerates.
    fn answer<T: Scalar>(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<T>)],
        answer: &mut Answer<T>,
    ) {
        let n = scene.topology.freedoms();
        let Answer { push, along, accelerations, multipliers, .. } = answer;
        // What is left along the freedoms accelerates them.
        along.clear();
        along.extend(self.basis.chunks_exact(n.max(1)).map(|z| {
            let mut sum = T::zero();
            for (z, p) in z.iter().zip(&*push) {
                sum += *p * T::from_f64(*z);
            }
            sum
        }));
        solve_factored(&self.factor, along);
        let chunks = self.basis.chunks_exact(n.max(1)).zip(self.moved.chunks_exact(n.max(1)));
        for ((vector, momentum), amount) in chunks.zip(&*along) {
            for (a, z) in accelerations.iter_mut().zip(vector) {
                *a += *amount * T::from_f64(*z);
            }
            for (p, m) in push.iter_mut().zip(momentum) {
                *p -= *amount * T::from_f64(*m);
            }
        }
        // `M a + h - f`, scaled, lies in what the rows span.
        push.iter_mut().zip(scene.columns).for_each(|(p, c)| *p *= T::from_f64(-c));
        self.space.amounts(push, multipliers);
        for (multiplier, row) in multipliers.iter_mut().zip(&self.rows.rows) {
            *multiplier *= T::from_f64(row.scale);
        }
        self.load_joints(scene, efforts, answer);
    }

    /// The wrenches of all joints from accelerations and multipliers, and what they must exert beyond.
    fn load_joints<T: Scalar>(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<T>)],
        answer: &mut Answer<T>,
    ) {
        let Scene { topology, bodies, masses, .. } = *scene;
        let Answer { accelerations, multipliers, sums, beyond, wrenches, .. } = answer;
        fill(sums, bodies.pose.len(), Twist::zero());
        for node in &topology.nodes {
            let mut sum = match (node.link, node.parent) {
                (Link::Joint { .. }, Some(parent)) => sums[topology.nodes[parent].body],
                _ => Twist::zero(),
            };
            for dof in node.dofs.clone() {
                sum += lift_twist(bodies.screws[dof]) * accelerations[dof];
            }
            sums[node.body] = sum;
            beyond[node.body] += masses.inertia[node.body].times(sum);
        }
        fill(wrenches, topology.joint_types.len(), Wrench::zero());
        let in_cuts = |joint: usize| matches!(topology.role[joint], Role::Cut { .. });
        for (row, multiplier) in self.rows.rows.iter().zip(&*multipliers) {
            if in_cuts(row.joint) {
                wrenches[row.joint] += lift_wrench(row.covector) * *multiplier;
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
    }
}

fn fill<T: Clone>(list: &mut Vec<T>, count: usize, with: T) {
    list.clear();
    list.resize(count, with);
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
    let mut factor = Vec::new();
    factorise(matrix, basis, n, may, (idle, &mut Vec::new(), &mut factor))?;
    Ok(factor)
}

/// The same in the room that is there; `moved` becomes `M Z`.
fn factorise(
    matrix: &[f64],
    basis: &mut [f64],
    n: usize,
    may: &dyn Fn(&[f64]) -> bool,
    (idle, moved, factor): (&mut Vec<Vec<f64>>, &mut Vec<f64>, &mut Vec<f64>),
) -> Result<(), Vec<f64>> {
    let n = n.max(1);
    let free = basis.len() / n;
    moved.clear();
    for z in basis.chunks_exact(n) {
        moved.extend(matrix.chunks_exact(n).map(|row| dot(row, z)));
    }
    fill(factor, free * free, 0.0);
    for (i, moved) in moved.chunks_exact(n).enumerate() {
        for (j, other) in basis.chunks_exact(n).enumerate().skip(i) {
            let entry = dot(moved, other);
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
                moved.swap(i * n + k, other * n + k);
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
    Ok(())
}

/// Moments about a spin without inertia below this part of their size are none: inertia below [`NOTHING`] leaves its
/// axis uncertain by the root of that.
const PUSHED: f64 = 1e-6;
/// Bodies slower than this part of the fastest stand.
const ALONE: f64 = 1e-6;

/// Inertia along a freedom below this part of the largest is rounding.
const NOTHING: f64 = 1e-14;

pub(super) fn solve_factored<T: Scalar>(factor: &[f64], right: &mut [T]) {
    let free = right.len();
    for i in 0..free {
        let mut sum = right[i];
        for k in 0..i {
            sum -= right[k] * T::from_f64(factor[i * free + k]);
        }
        right[i] = sum / T::from_f64(factor[i * free + i]);
    }
    for i in (0..free).rev() {
        let mut sum = right[i];
        for k in i + 1..free {
            sum -= right[k] * T::from_f64(factor[k * free + i]);
        }
        right[i] = sum / T::from_f64(factor[i * free + i]);
    }
}
