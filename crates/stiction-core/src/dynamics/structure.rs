//! Structure of the sparse balance equations of inverse dynamics: unknowns, equations and
//! weighting.
//!
//! Unknowns are the wrenches at cut joints (constraints and efforts), the accelerations of local
//! degrees of freedom, and the multipliers of gearings, which act on several DOFs of the spanning
//! tree. Each unactuated DOF of the tree contributes one equation: except for friction, the wrench
//! that its joint transmits does no work along the DOF. All other wrenches follow by recursion: a
//! tree joint transmits the inverse-dynamics wrench of the bodies beyond it, minus the wrenches of
//! the cut joints on these bodies.
//!
//! If unknowns outnumber equations, constraints or actuators are redundant, and a declared
//! weighting selects a solution: the system is bordered by the optimality conditions, `[H A^T; A
//! 0]`.
//!
//! Equation (B8) of the book's theory.

use crate::linalg::Entry;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::topology::{Link, Topology};
use core::ops::Range;

/// Weighting that selects a solution of a redundant balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// No redundancy: the balance determines all unknowns.
    Determined,
    /// Constraints are redundant. The reactions minimise the sum over all joints of `|force|^2 +
    /// |moment|^2/length^2`, with moments about the origin of the joint and the characteristic
    /// length `length`. This sum is the elastic energy of equally compliant joints, independent of
    /// units and of the choice of cut joints. Efforts do not depend on this weighting.
    LeastReactions,
    /// Constraints are redundant and joints declare compliances. The reactions minimise the elastic
    /// energy, with moments about the origin of the joint. Joints without declared compliance are
    /// rigid.
    LeastEnergy,
    /// Actuators are redundant. The efforts minimise the sum of their squares, with torques divided
    /// by the characteristic length.
    LeastEfforts,
}

/// Wrench or effort in the quadratic function that the weighting minimises, and the wrenches at cut
/// joints that contribute to this wrench or effort.
#[derive(Clone, Debug)]
pub(super) struct Weighed {
    pub(super) what: WeighedKind,
    /// Indices of the cut joints whose wrenches contribute to this wrench or effort, each with the
    /// sign of its contribution. Empty for an actuator at a cut joint.
    pub(super) cuts: Vec<(usize, f64)>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum WeighedKind {
    /// Wrench at the joint of the spanning-tree node with this index.
    Node(usize),
    /// Wrench at the cut joint with this index among the cut joints.
    Cut(usize),
    /// Effort of the actuator at a DOF of the spanning tree.
    Actuator { tree_dof: usize },
    /// Effort of an actuator at a cut joint. This effort is an unknown, and `column` is its matrix
    /// column.
    CutActuator { column: usize },
}

/// Matrix column of the multiplier of a gearing.
#[derive(Clone, Debug)]
pub(super) struct GearingColumn {
    /// Index of the gearing among the gearings of the mechanism.
    pub(super) gearing: usize,
    /// Degrees of freedom of the spanning tree on which the gearing acts, in the order of the
    /// coefficients of the gearing. The second entry of each pair is the index of the balance
    /// equation of the degree of freedom, or `None` if the degree of freedom is actuated.
    pub(super) dofs: Vec<(usize, Option<usize>)>,
}

/// Unknowns, equations and sparsity pattern of the balance.
#[derive(Clone, Debug)]
pub(crate) struct BalanceStructure {
    pub(super) weighting: Weighting,
    /// Unactuated DOFs of the spanning tree, in the order of the balance equations.
    pub(super) passive: Vec<usize>,
    /// For each DOF of the spanning tree, the index of its balance equation; `None` if it is
    /// actuated.
    pub(super) equation_of: Vec<Option<usize>>,
    /// Matrix columns of the wrench unknowns of each cut joint.
    pub(super) columns_of: Vec<Vec<usize>>,
    /// Number of columns for wrenches at cut joints. The columns of local degrees of freedom
    /// follow, then those of gearings.
    pub(super) wrench_columns: usize,
    /// For each local degree of freedom, the tree nodes whose bodies it accelerates, and all
    /// ancestors of these nodes.
    pub(super) spin_nodes: Vec<Vec<usize>>,
    pub(super) gearings: Vec<GearingColumn>,
    pub(super) weighed: Vec<Weighed>,
    pub(super) entries: Vec<Entry>,
}

impl BalanceStructure {
    /// Creates the structure of the balance for a weighting. `spin_bodies` lists the bodies that
    /// each local degree of freedom accelerates.
    pub(super) fn new(
        topology: &Topology,
        weighting: Weighting,
        spin_bodies: &[Vec<usize>],
    ) -> Self {
        let passive: Vec<usize> =
            (0..topology.dofs()).filter(|&d| topology.tree_dofs[d].actuator.is_none()).collect();
        let mut equation_of = vec![None; topology.dofs()];
        for (equation, &tree_dof) in passive.iter().enumerate() {
            equation_of[tree_dof] = Some(equation);
        }
        let columns_of: Vec<Vec<usize>> =
            topology.cuts.iter().map(|cut| cut.columns(topology.constraints).collect()).collect();
        let spin_nodes = spin_bodies
            .iter()
            .map(|bodies| {
                let mut nodes: Vec<usize> =
                    bodies.iter().flat_map(|&body| topology.ancestors(body)).collect();
                nodes.sort_unstable();
                nodes.dedup();
                nodes
            })
            .collect();
        let gearings = topology
            .gearings
            .iter()
            .map(|own| {
                let dofs = own.dofs.iter().map(|&(tree_dof, _)| (tree_dof, equation_of[tree_dof]));
                GearingColumn { gearing: own.gearing, dofs: dofs.collect() }
            })
            .collect();
        let mut structure = Self {
            weighting,
            gearings,
            passive,
            equation_of,
            columns_of,
            wrench_columns: topology.columns(),
            spin_nodes,
            weighed: weighed(topology, weighting),
            entries: Vec::new(),
        };
        structure.entries = structure.pattern(topology);
        structure
    }

    /// Returns true if the wrenches at the cut joints determine all forces: there is no redundancy,
    /// no gearing, no local degree of freedom and no actuator at a cut joint.
    pub(super) fn is_plain(&self, topology: &Topology) -> bool {
        self.weighting == Weighting::Determined
            && self.gearings.is_empty()
            && self.spin_nodes.is_empty()
            && topology.cut_actuators.is_empty()
    }

    /// Returns the number of columns for wrenches, local degrees of freedom and gearings. The
    /// columns of the Lagrange multipliers of the weighting are not counted.
    pub(super) fn unknowns(&self) -> usize {
        self.first_gearing() + self.gearings.len()
    }

    /// Returns the column of the first gearing.
    pub(super) fn first_gearing(&self) -> usize {
        self.wrench_columns + self.spin_nodes.len()
    }

    /// Returns the number of all columns, including those of the Lagrange multipliers of the
    /// weighting.
    pub(super) fn size(&self) -> usize {
        match self.weighting {
            Weighting::Determined => self.unknowns(),
            _ => self.unknowns() + self.passive.len(),
        }
    }

    /// Returns the number of rows; equal to [`Self::size`] for a solvable balance.
    pub(super) fn rows(&self) -> usize {
        self.first_balance_row() + self.passive.len()
    }

    /// Returns the row of the first balance equation. Optimality conditions precede the balance
    /// equations.
    pub(super) fn first_balance_row(&self) -> usize {
        match self.weighting {
            Weighting::Determined => 0,
            _ => self.unknowns(),
        }
    }

    /// Returns the range of the columns of the Lagrange multipliers of the weighting, one for each
    /// balance equation.
    pub(super) fn multipliers(&self) -> Range<usize> {
        self.unknowns()..self.size()
    }

    /// Subtracts the efforts that gearings exert on actuated DOFs from `efforts`, the efforts of
    /// all actuators. `columns` contains the value of the unknown of each matrix column.
    pub(super) fn subtract_gearings<T: Scalar>(
        &self,
        topology: &Topology,
        parameters: &Parameters<T>,
        columns: &[T],
        efforts: &mut [T],
    ) {
        for (index, gearing) in self.gearings.iter().enumerate() {
            let multiplier = columns[self.first_gearing() + index];
            let coefficients = &parameters.gearings[gearing.gearing].coefficients;
            for (&(tree_dof, _), &coefficient) in gearing.dofs.iter().zip(coefficients) {
                if let Some(actuator) = topology.tree_dofs[tree_dof].actuator {
                    efforts[actuator] -= coefficient * multiplier;
                }
            }
        }
    }

    /// Lists the entries of the matrix in the order in which [`super::balance`] computes them.
    fn pattern(&self, topology: &Topology) -> Vec<Entry> {
        let mut entries = Vec::new();
        let first = self.first_balance_row();
        let bordered = self.weighting != Weighting::Determined;
        self.visit_balance(topology, |equation, column| {
            entries.push(Entry { row: first + equation, column });
            if bordered {
                entries.push(Entry { row: column, column: self.unknowns() + equation });
            }
        });
        for weighed in &self.weighed {
            match weighed.what {
                WeighedKind::CutActuator { column } => entries.push(Entry { row: column, column }),
                _ => {
                    for &(a, _) in &weighed.cuts {
                        for &row in &self.columns_of[a] {
                            for &(b, _) in &weighed.cuts {
                                let columns = &self.columns_of[b];
                                entries.extend(columns.iter().map(|&column| Entry { row, column }));
                            }
                        }
                    }
                }
            }
        }
        entries
    }

    /// Calls `visit(equation, column)` for each entry of the balance matrix without optimality
    /// conditions.
    fn visit_balance(&self, topology: &Topology, mut visit: impl FnMut(usize, usize)) {
        let mut equation_of = vec![None; topology.dofs()];
        for (equation, &tree_dof) in self.passive.iter().enumerate() {
            equation_of[tree_dof] = Some(equation);
        }
        for (cut, columns) in topology.cuts.iter().zip(&self.columns_of) {
            for &(node, _) in &cut.path {
                for equation in
                    topology.nodes[node].tree_dofs.clone().filter_map(|d| equation_of[d])
                {
                    columns.iter().for_each(|&column| visit(equation, column));
                }
            }
        }
        for (spin, nodes) in self.spin_nodes.iter().enumerate() {
            for &node in nodes {
                for equation in
                    topology.nodes[node].tree_dofs.clone().filter_map(|d| equation_of[d])
                {
                    visit(equation, self.wrench_columns + spin);
                }
            }
        }
        for (index, gearing) in self.gearings.iter().enumerate() {
            for equation in gearing.dofs.iter().filter_map(|(_, equation)| *equation) {
                visit(equation, self.first_gearing() + index);
            }
        }
    }
}

fn weighed(topology: &Topology, weighting: Weighting) -> Vec<Weighed> {
    let mut through = vec![Vec::new(); topology.nodes.len()];
    for (index, cut) in topology.cuts.iter().enumerate() {
        for &(node, sign) in &cut.path {
            // If the tree joint lies on the successor's side of the cut joint, the wrench of the
            // cut joint is subtracted from the wrench of the tree joint.
            through[node].push((index, -sign));
        }
    }
    match weighting {
        Weighting::Determined => Vec::new(),
        Weighting::LeastReactions | Weighting::LeastEnergy => {
            let nodes = through.into_iter().enumerate().filter(|(node, cuts)| {
                let transmits = matches!(topology.nodes[*node].link, Link::Joint { .. });
                transmits && !cuts.is_empty()
            });
            let nodes = nodes.map(|(node, cuts)| Weighed { what: WeighedKind::Node(node), cuts });
            let cuts = (0..topology.cuts.len())
                .map(|cut| Weighed { what: WeighedKind::Cut(cut), cuts: vec![(cut, 1.0)] });
            nodes.chain(cuts).collect()
        }
        Weighting::LeastEfforts => {
            let driven = (0..topology.dofs()).filter(|&d| topology.tree_dofs[d].actuator.is_some());
            let tree = driven.map(|tree_dof| Weighed {
                what: WeighedKind::Actuator { tree_dof },
                cuts: through[topology.tree_dofs[tree_dof].node].clone(),
            });
            let cut = (topology.constraints..topology.columns()).map(|column| Weighed {
                what: WeighedKind::CutActuator { column },
                cuts: Vec::new(),
            });
            tree.filter(|weighed| !weighed.cuts.is_empty()).chain(cut).collect()
        }
    }
}
