//! Sparse factorisation of the equations of motion: elimination of the spanning tree, then of the
//! loop closures.

use super::stages::Stages;
use super::{Balance, fill};
use crate::forward::Forward;
use crate::forward::constraint_jacobian::{ConstraintRow, ConstraintRows};
use crate::forward::data::Data;
use crate::forward::sparse::articulated::Articulated;
use crate::forward::sparse::closures::{Buffers, Closures, Place};
use crate::linalg::{BLOCK, Part, dot, largest};
use crate::spatial::{Vec3, Wrench};
use crate::topology::{Link, Role, Topology};

/// The iteration for the minimum-norm reactions ends when the multipliers change by less than this
/// fraction of the largest multiplier. The iteration is needed because a matrix is added to make
/// the system definite, which causes an error in the first solution.
const LEAST: f64 = 1e-12;
/// Largest number of iterations for the minimum-norm reactions.
const CHANGES: usize = 4;

/// Equations of motion at one configuration under given constraints, factorised by sparse
/// elimination.
#[derive(Clone, Debug)]
pub(super) struct SparseBalance {
    tree: Articulated,
    closures: Closures,
    /// Flag for each DOF of the spanning tree: true if a constraint row prescribes its
    /// acceleration.
    prescribed: Vec<bool>,
    /// Prescribed DOFs of the spanning tree, each with the index of its constraint row.
    rows: Vec<(usize, usize)>,
    /// True if any constraint is redundant.
    is_redundant: bool,
    /// True if static friction or actuators constrain DOFs of cut joints.
    holds_cuts: bool,
    loops: Loops,
}

/// Constraint wrenches of the loops, and the loops that pass through each joint of the spanning
/// tree.
#[derive(Clone, Debug)]
struct Loops {
    /// Unit wrenches of the constraint rows of each loop closure (block).
    covectors: Vec<Vec<Wrench<f64>>>,
    /// For each tree node, the loop closures (blocks) whose loops pass through the joint of the
    /// node, each with the sign of the joint in the loop, 1 or -1.
    through: Vec<Vec<(usize, f64)>>,
}

impl Loops {
    fn new(topology: &Topology) -> Self {
        let mut through = vec![Vec::new(); topology.nodes.len()];
        for (block, cut) in topology.cuts.iter().enumerate() {
            cut.path.iter().for_each(|(node, sign)| through[*node].push((block, *sign)));
        }
        Self { covectors: vec![Vec::with_capacity(BLOCK); topology.cuts.len()], through }
    }

    fn update(&mut self, topology: &Topology, rows: &[ConstraintRow]) {
        self.covectors.iter_mut().for_each(Vec::clear);
        for row in rows {
            if let Role::Cut { cut } = topology.role[row.joint] {
                self.covectors[cut].push(row.covector);
            }
        }
    }
}

/// Buffers for the computation of responses with the sparse factorisation.
#[derive(Clone, Debug, Default)]
pub(super) struct SparseWorkspace {
    carried: Vec<Part>,
    reduced: Vec<f64>,
    multipliers: Vec<Part>,
    change: Vec<Part>,
    rest: Vec<Part>,
    along: Vec<f64>,
    correction: Vec<f64>,
    closures: Buffers,
}

impl SparseBalance {
    /// Allocates the sparse factorisation of a model. Returns `None` if the model uses only dense
    /// linear algebra.
    pub(super) fn new(model: &Forward) -> Option<Self> {
        let closures = Closures::clone(model.closures.as_ref()?);
        Some(Self {
            tree: Articulated::default(),
            closures,
            prescribed: Vec::new(),
            rows: Vec::new(),
            is_redundant: false,
            holds_cuts: false,
            loops: Loops::new(&model.topology),
        })
    }

    /// Factorises the equations of motion at the configuration of `data`. Returns false if the
    /// dense factorisation must be used instead: for DOFs with several constraint rows, for motions
    /// without inertia, for singular configurations, and for redundant constraints if there are
    /// also prescribed actuators, static friction or declared compliances.
    pub(super) fn update(&mut self, model: &Forward, data: &Data, rows: &ConstraintRows) -> bool {
        let (topology, parameters) = (&model.topology, &model.parameters);
        let Self { tree, closures, prescribed, rows: of_tree, is_redundant, holds_cuts, loops } =
            self;
        if !closures.assign(topology, &rows.rows) {
            return false;
        }
        fill(prescribed, topology.dofs(), false);
        of_tree.clear();
        let first = topology.closures();
        for (index, row) in rows.rows.iter().enumerate() {
            let Role::Tree { node } = topology.role[row.joint] else { continue };
            let Some(dof) = row.dof else { return false };
            let tree_dof = topology.nodes[node].tree_dofs.start + dof;
            if prescribed[tree_dof] {
                return false;
            }
            prescribed[tree_dof] = true;
            of_tree.push((tree_dof, index));
        }
        if !tree.update((topology, parameters), (&data.bodies, &data.masses), prescribed) {
            return false;
        }
        for (row, place) in rows.rows.iter().zip(0..) {
            let Some(at) = closures.places[place] else { continue };
            let (predecessor, successor) = topology.ends[row.joint];
            for (body, wrench) in [(successor, row.covector), (predecessor, -row.covector)] {
                tree.reduce(topology, body, wrench, |d, force| closures.add(d, at, force));
            }
            let column = |d: usize| if prescribed[d] { 0.0 } else { model.columns[d] };
            closures.set_size(at, row.size((topology, parameters), &data.bodies, column));
        }
        let weights = tree.pivots.iter().map(|pivot| 1.0 / pivot);
        loops.update(topology, &rows.rows);
        let definite =
            |put: &mut dyn FnMut(Place, Place, f64)| each_pair((model, data), loops, put);
        if !closures.factor(weights, &definite) {
            return false;
        }
        let in_cuts = closures.places.iter().flatten().count();
        *holds_cuts = in_cuts > topology.constraints;
        *is_redundant = closures.rank < in_cuts;
        !*is_redundant || (rows.rows.len() == first && parameters.compliance.is_none())
    }

    /// Returns the mobility: the number of DOFs that the constraints leave.
    pub(super) fn mobility(&self) -> usize {
        self.prescribed.len() - self.rows.len() - self.closures.rank
    }

    /// Returns the number of redundant constraints.
    pub(super) fn redundant(&self) -> usize {
        self.closures.places.iter().flatten().count() - self.closures.rank
    }

    /// Returns the singularity index, see [`Balance::distance`].
    pub(super) fn distance(&self) -> f64 {
        self.closures.distance
    }
}

impl Balance {
    /// Computes a response by the sparse factorisation, from the generalised forces (including
    /// efforts) and from the wrench that the joints must exert on each body at zero acceleration of
    /// the spanning tree.
    pub(super) fn respond_sparse(
        &self,
        sparse: &SparseBalance,
        (model, data): (&Forward, &Data),
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
        (one, buffers): (&mut Stages<f64>, &mut SparseWorkspace),
    ) {
        let (topology, rows) = (&model.topology, &self.rows.rows);
        let SparseBalance { tree, closures, .. } = sparse;
        let SparseWorkspace {
            carried,
            reduced,
            multipliers,
            change,
            rest,
            along,
            correction,
            closures: more,
        } = buffers;
        for &(tree_dof, row) in &sparse.rows {
            one.accelerations[tree_dof] = if whole { rows[row].right } else { 0.0 };
        }
        reduced.clone_from(&one.forces);
        tree.reduce_all(topology, &one.accelerations, reduced, carried);
        fill(multipliers, topology.cuts.len(), [0.0; BLOCK]);
        if whole {
            for (row, place) in rows.iter().zip(&closures.places) {
                if let Some(at) = place {
                    multipliers[at.block][at.row] = row.right;
                }
            }
        }
        closures.scaled(multipliers);
        let pivots = &tree.pivots;
        let known = |d: usize| match pivots[d].is_finite() {
            true => reduced[d] / pivots[d],
            false => one.accelerations[d],
        };
        closures.add_product(known, -1.0, multipliers);
        closures.solve(multipliers, more);
        one.demand_at_rest.clone_from(&one.demand);
        for changes in 0.. {
            along.clear();
            along.extend((0..pivots.len()).map(|d| reduced[d] + closures.along(d, multipliers)));
            tree.accelerate(topology, along, &mut one.accelerations, carried);
            if sparse.holds_cuts {
                // If friction locks the mechanism, the accelerations vanish, but their round-off is
                // that of the much larger accelerations without constraints. A second solution
                // removes this round-off.
                fill(rest, multipliers.len(), [0.0; BLOCK]);
                let of = (&**topology, &model.parameters);
                for (index, place) in closures.places.iter().enumerate() {
                    if let Some(at) = place {
                        let right = if whole { rows[index].right } else { 0.0 };
                        let own = self.rows.product(of, &data.bodies, index, &one.accelerations);
                        rest[at.block][at.row] = right - own;
                    }
                }
                closures.scaled(rest);
                closures.solve(rest, more);
                along.clear();
                along.extend((0..pivots.len()).map(|d| closures.along(d, rest)));
                fill(correction, pivots.len(), 0.0);
                tree.accelerate(topology, along, correction, carried);
                one.accelerations.iter_mut().zip(&*correction).for_each(|(a, c)| *a += c);
                for (sum, rest) in multipliers.iter_mut().zip(&*rest) {
                    (0..BLOCK).for_each(|k| sum[k] += rest[k]);
                }
            }
            one.multipliers.clear();
            one.multipliers.extend(
                closures
                    .places
                    .iter()
                    .map(|place| place.map_or(0.0, |at| closures.unscaled(multipliers, at))),
            );
            one.demand.clone_from(&one.demand_at_rest);
            self.load_joints(model, data, efforts, whole, one);
            if !sparse.is_redundant || changes == CHANGES {
                break;
            }
            // Adds the self-stresses that minimise the reactions, then a correction in the row
            // space, because the added definite matrix has changed the multipliers there.
            fill(change, multipliers.len(), [0.0; BLOCK]);
            gradient((model, data), rows, &closures.places, one, change);
            closures.scaled(change);
            change.iter_mut().flatten().for_each(|x| *x *= -closures.added);
            closures.solve_once(change, more);
            fill(rest, multipliers.len(), [0.0; BLOCK]);
            closures.add_system(change, -1.0, rest, along);
            closures.solve(rest, more);
            for ((sum, change), rest) in multipliers.iter_mut().zip(&mut *change).zip(&*rest) {
                (0..BLOCK).for_each(|k| change[k] += rest[k]);
                (0..BLOCK).for_each(|k| sum[k] += change[k]);
            }
            if largest(change.as_flattened()) <= LEAST * largest(multipliers.as_flattened()) {
                break;
            }
        }
        // The multiplier of a constraint row in the spanning tree is the effort that the joint must
        // transmit, minus the given generalised force on its DOF.
        for &(tree_dof, row) in &sparse.rows {
            let joint = rows[row].joint;
            let Role::Tree { node } = topology.role[joint] else { continue };
            let demand = one.demand[topology.nodes[node].body];
            let given = one.forces[tree_dof] + if whole { data.masses.bias[tree_dof] } else { 0.0 };
            one.multipliers[row] = data.bodies.screws[tree_dof].power(demand) - given;
        }
    }
}

/// Returns the components of a joint wrench in world axes whose sum of squares the reactions of
/// redundant constraints minimise: the force, N, then the moment about the origin of frame J
/// divided by the characteristic length, N.
fn weighed(model: &Forward, data: &Data, joint: usize, wrench: &Wrench<f64>) -> Part {
    let moment = wrench.moment_about(data.bodies.frame_j[joint].position);
    let moment: Vec3<f64> = moment * (1.0 / model.parameters.length);
    let force = wrench.force;
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}

/// Calls `put` with the two rows and the value of each contribution to half the Hessian of the sum
/// of squares of all reactions, with respect to the multipliers of rows at cut joints. The
/// contributions to an entry must be added up. Of each pair of different blocks, only one order is
/// visited, because the matrix is symmetric.
fn each_pair(
    (model, data): (&Forward, &Data),
    loops: &Loops,
    put: &mut dyn FnMut(Place, Place, f64),
) {
    let (topology, of_cut) = (&model.topology, &loops.covectors);
    let mut add = |joint: usize, (a, of_a): (usize, f64), (b, of_b): (usize, f64)| {
        let mut seconds = [[0.0; BLOCK]; BLOCK];
        for (second, covector) in seconds.iter_mut().zip(&of_cut[b]) {
            *second = weighed(model, data, joint, covector);
        }
        for (i, first) in of_cut[a].iter().enumerate() {
            let first = weighed(model, data, joint, first).map(|x| of_a * of_b * x);
            for (j, second) in seconds[..of_cut[b].len()].iter().enumerate() {
                put(Place { block: a, row: i }, Place { block: b, row: j }, dot(&first, second));
            }
        }
    };
    for (block, cut) in topology.cuts.iter().enumerate() {
        add(cut.joint, (block, 1.0), (block, 1.0));
    }
    for (node, own) in topology.nodes.iter().zip(&loops.through) {
        let Link::Joint { joint, .. } = node.link else { continue };
        for (k, a) in own.iter().enumerate() {
            own[..=k].iter().for_each(|b| add(joint, *a, *b));
        }
    }
}

/// Adds to `to` half the gradient of the sum of squares of all reactions with respect to the
/// multipliers of rows at cut joints.
fn gradient(
    (model, data): (&Forward, &Data),
    rows: &[ConstraintRow],
    places: &[Option<Place>],
    one: &Stages<f64>,
    to: &mut [Part],
) {
    let topology = &model.topology;
    for (row, place) in rows.iter().zip(places) {
        let (Some(at), Role::Cut { cut }) = (place, topology.role[row.joint]) else { continue };
        let joint = row.joint;
        let own = weighed(model, data, joint, &one.wrenches[joint]);
        let mut sum = dot(&own, &weighed(model, data, joint, &row.covector));
        for &(node, sign) in &topology.cuts[cut].path {
            // A unit multiplier changes the wrench of each tree joint in the loop by `-sign` times
            // the covector of the row.
            let Link::Joint { joint, .. } = topology.nodes[node].link else { continue };
            let demand = weighed(model, data, joint, &one.demand[topology.nodes[node].body]);
            sum -= sign * dot(&demand, &weighed(model, data, joint, &row.covector));
        }
        to[at.block][at.row] += sum;
    }
}
