//! Recording of forward dynamics: an evaluation of inverse dynamics, its changes due to unit
//! accelerations and unit friction forces, and the coupling of friction with the reactions.
//!
//! Let `a` be the accelerations of the prescribed coordinates, whose number is that of the
//! actuators, and `f` the friction forces. Actuator forces are `h + M a + C f`, and joint wrenches
//! are `w + W a + R f`. For given actuator forces `t`, friction forces determine the accelerations
//! by `M a = t - h - C f`. Multiples of this equation are added to the wrenches, so that most
//! entries of `R` vanish (`locality`). Wrenches therefore follow from the accelerations and a few
//! friction forces instead of from all friction forces.
//!
//! Expressions in the accelerations are first recorded with these as inputs. The solutions of the
//! linear systems then replace the inputs. The coupling is solved in the merged graph. Therefore
//! the bounds of rounding errors, with which value numbering distinguishes nodes, do not grow
//! through solutions of linear systems.
//!
//! Equations (P4) to (P6) of the book's theory.

use crate::forward_kernel::{KernelResults, SOLUTIONS};
use crate::graph::{Graph, Node};
use crate::locality::WrenchForm;
use crate::recorded::{Recorded, extend_graph, record_groups};
use crate::recording::RecordingSource;
use crate::samples::Sample;
use crate::small_lu::{Factors, diagonal};
use crate::stages::{holds, with_inputs_replaced};
use crate::value_numbering::{Merged, merge};
use stiction_core::random::Random;
use stiction_core::scalar::Scalar;

/// Results of all stages of a forward-dynamics program, as nodes of one graph. Inputs of the graph
/// include two sets of estimated normal loads of the coupled interfaces.
pub(crate) struct ForwardStages {
    pub(crate) graph: Graph,
    /// Accelerations and reactions without friction.
    pub(crate) ideal: Vec<Node>,
    /// Normal loads of the coupled interfaces under the friction that the frictionless normal loads
    /// cause.
    pub(crate) begin: Vec<Node>,
    /// Normal loads of the coupled interfaces after a Newton step from the first set of estimated
    /// normal loads, then the determinant of the matrix of this step, relative to that without
    /// friction.
    pub(crate) newton: Vec<Node>,
    /// Normal loads of the coupled interfaces after a chord step from the second set of estimated
    /// normal loads, with the matrix of the Newton step from the first set.
    pub(crate) chord: Vec<Node>,
    /// Accelerations, reactions, normal loads, sliding velocities and friction forces for the
    /// second set of estimated normal loads.
    pub(crate) rest: Vec<Node>,
    /// Guards of the results without friction, and of those with friction. A guard is positive
    /// while the assumptions made at recording hold.
    pub(crate) guards: [Node; 2],
    /// For each coupled interface, `true` if its friction changes a normal load.
    pub(crate) couples: Vec<bool>,
}

impl RecordingSource<'_> {
    /// Records and merges all stages; `coupled` lists the interfaces whose friction changes a
    /// normal load. Replacements in `form` that need divisions are removed.
    pub(crate) fn record_forward(
        &self,
        coupled: &[usize],
        pivots: &[(usize, usize)],
        form: &mut WrenchForm,
        samples: &[Sample],
    ) -> ForwardStages {
        let counts = self.counts(coupled.len());
        let (count, unknowns) = (coupled.len(), counts.targets);
        let given = counts.inputs() + counts.drives + 2 * count;
        let replaced = unknowns + count + (SOLUTIONS - 1) * unknowns;
        let (graph, groups) = record_groups(given + replaced, |inputs| {
            self.follow_forward(&counts, coupled, form, inputs).into_array()
        });
        // Efforts, normal loads and accelerations are independent inputs, so random values are
        // suitable.
        let mut random = Random::new(3);
        let rows: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let mut sample = sample.of_tree();
                sample.extend((0..counts.drives).map(|_| 100.0 * random.number()));
                sample.extend((0..2 * count).map(|_| 50.0 + 40.0 * random.number()));
                sample.extend((0..unknowns).map(|_| random.number()));
                sample.extend((0..count).map(|_| 50.0 + 40.0 * random.number()));
                sample.extend((unknowns + count..replaced).map(|_| random.number()));
                sample
            })
            .collect();
        let Merged { graph: mut merged, new_of, guards } = merge(&graph, &rows);
        let all = KernelResults::from_array(groups.each_ref().map(Vec::as_slice));
        let KernelResults { masses, rights, ideal, begin, slopes, found, rest, ratios, .. } = all;
        let (efforts, start) = (all.per_load, all.frictionless);
        let with_friction = [masses, rights, efforts, start, begin, slopes, found, rest].concat();
        let without = [masses, &rights[..unknowns], ideal].concat();
        let guards =
            [&without, &with_friction].map(|s: &Vec<Node>| holds(&graph, s, &guards, &mut merged));
        let new = |nodes: &[Node]| -> Vec<Node> {
            nodes.iter().map(|node| new_of[*node as usize]).collect()
        };
        if form.remove_divisions(&merged, &new(ratios)) {
            return self.record_forward(coupled, pivots, form, samples);
        }
        let systems = [new(masses), new(rights)].concat();
        let (graph, solutions) = extend_graph(merged, &systems, |systems| {
            let (masses, rights) = systems.split_at(unknowns * unknowns);
            let masses = Factors::new(&square(masses, unknowns), pivots.to_vec());
            let solutions = rights.chunks(unknowns).flat_map(|right| masses.solve(right));
            solutions.chain(masses.reciprocal_pivots()).collect()
        });
        let (first, others) = solutions[..SOLUTIONS * unknowns].split_at(unknowns);
        let by = [first, &new(start), others].concat();
        let (graph, newer_of) = with_inputs_replaced(&graph, given, &by);
        let newer = |node: Node| newer_of[node as usize];
        let now = |nodes: &[Node]| -> Vec<Node> {
            nodes.iter().map(|node| newer(new_of[*node as usize])).collect()
        };
        let [masses, efforts, slopes, found] = [masses, efforts, slopes, found].map(now);
        let couples = couples(&graph, &slopes, &efforts, count, unknowns);
        let frictionless: Vec<Node> =
            solutions[SOLUTIONS * unknowns..].iter().map(|node| newer(*node)).collect();
        let system = [&masses[..], &efforts, &slopes, &found, &frictionless].concat();
        let (graph, mut newton) = extend_graph(graph, &system, |system| {
            let (masses, rest) = system.split_at(masses.len());
            let (efforts, rest) = rest.split_at(efforts.len());
            let (slopes, rest) = rest.split_at(slopes.len());
            let (found, frictionless) = rest.split_at(found.len());
            let matrix = bordered(&square(masses, unknowns), efforts, slopes, count);
            let order = pivots.iter().map(|&(row, column)| (count + row, count + column));
            let factors = Factors::new(&matrix, diagonal(count).into_iter().chain(order).collect());
            // Normal loads that result from the estimates, and the estimates, for both sets.
            let of = |k: usize| &found[k * count..(k + 1) * count];
            let step = |found: &[Recorded], estimates: &[Recorded]| -> Vec<Recorded> {
                let mut residuals: Vec<Recorded> = estimates
                    .iter()
                    .zip(found)
                    .map(|(estimate, found)| *estimate - *found)
                    .collect();
                // The accelerations satisfy their equations for any estimates.
                residuals.resize(count + unknowns, Recorded::zero());
                let changes = factors.solve(&residuals);
                estimates.iter().zip(changes).map(|(estimate, change)| *estimate - change).collect()
            };
            let mut steps = step(of(0), of(2));
            steps.push(factors.determinant_relative_to(frictionless));
            steps.extend(step(of(1), of(3)));
            steps
        });
        let chord = newton.split_off(count + 1);
        ForwardStages {
            ideal: now(ideal),
            begin: now(begin),
            newton,
            chord,
            rest: now(rest),
            guards: guards.map(newer),
            couples,
            graph,
        }
    }
}

/// Rows of a square matrix that is given row by row.
fn square(entries: &[Recorded], size: usize) -> Vec<Vec<Recorded>> {
    (0..size).map(|row| entries[row * size..][..size].to_vec()).collect()
}

/// Matrix of a Newton step for `count` normal loads and all accelerations: the residuals of the
/// normal loads, then those of the accelerations. Each interface has entries in a few columns, so
/// that elimination of the normal loads, interface by interface, costs little.
fn bordered(
    masses: &[Vec<Recorded>],
    efforts: &[Recorded],
    slopes: &[Recorded],
    count: usize,
) -> Vec<Vec<Recorded>> {
    let columns = count + masses.len();
    let of_load = |row: usize| {
        let entry = |column: usize| {
            let own = Recorded::from_f64(if row == column { 1.0 } else { 0.0 });
            own - slopes[row * columns + column]
        };
        (0..columns).map(entry).collect()
    };
    let of_effort = |row: usize| [&efforts[row * count..][..count], &masses[row]].concat();
    (0..count).map(of_load).chain((0..masses.len()).map(of_effort)).collect()
}

/// Tells for each interface whether its normal load changes a normal load by friction, at fixed
/// accelerations or through the accelerations. Friction that does not depend on normal loads is
/// always part of the loads. The normal loads have the derivatives `slopes`, and the efforts the
/// derivatives `efforts`, with respect to normal loads.
fn couples(
    graph: &Graph,
    slopes: &[Node],
    efforts: &[Node],
    count: usize,
    unknowns: usize,
) -> Vec<bool> {
    let is_set = |node: &Node| graph.constant(*node) != Some(0.0);
    let rows = || slopes.chunks(count + unknowns);
    let accelerated = rows().any(|row| row[count..].iter().any(is_set));
    let of = |interface: usize| {
        let moves = || efforts.chunks(count).any(|row| is_set(&row[interface]));
        rows().any(|row| is_set(&row[interface])) || accelerated && moves()
    };
    (0..count).map(of).collect()
}
