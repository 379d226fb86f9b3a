//! Motion constraints (loop closures, gearings, prescribed coordinates, passive spins with zero
//! rate) as rows of the linear system of [`super::system`], and the nonzero pattern of this
//! system.

use super::coordinate::Coordinate;
use super::measure::{self, Difference};
use crate::linalg::Entry;
use crate::mechanism::BodyId;
use crate::spatial::Vec3;
use crate::topology::Topology;

/// Constraints on the motion: loop closures, gearings, prescribed coordinates, and passive spins
/// whose rate is set to zero.
#[derive(Clone, Debug)]
pub struct MotionConstraints {
    pub(super) rows: Vec<Row>,
    /// Number of loop-closure rows. They are the first rows of the system: constraints of cut
    /// joints, followed by gearings.
    pub(super) closures: usize,
    pub(super) coordinates: Vec<Coordinate>,
    /// For each prescribed coordinate that is a component of a rotation vector: the indices of all
    /// three components of that vector among the prescribed coordinates. `None` if they are not
    /// all prescribed, and for other coordinates.
    pub(super) orientations: Vec<Option<[usize; 3]>>,
    pub(super) differences: Vec<Difference>,
    pub(super) spins: Vec<Spin>,
    pub(super) entries: Vec<Entry>,
}

/// Row of the linear system. Its path lists the spanning-tree nodes whose degrees of freedom
/// appear in the row, each with the sign of its contribution.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) path: Vec<(usize, f64)>,
    /// True if the error of the row is an angle, false if it is a length.
    pub(super) is_angle: bool,
    /// Index in [`Topology::gearings`]; `None` if the row does not belong to a gearing.
    pub(super) gearing: Option<usize>,
}

/// Passive spin: rotation of one body about a body-fixed axis that neither the prescribed motion
/// nor the loops determine, such as the spin of a rod between two ball joints. By convention the
/// spin rate is zero; the dynamics determine the spin acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// Body that rotates.
    pub body: BodyId,
    /// Unit vector along the rotation axis, in the body's axes.
    pub axis: Vec3<f64>,
}

impl MotionConstraints {
    /// Creates the constraints of all loops and gearings, of the prescribed `coordinates`, and of
    /// the passive `spins` whose rate is set to zero.
    pub fn new(topology: &Topology, coordinates: &[Coordinate], spins: &[Spin]) -> Self {
        let mut rows = Vec::new();
        for cut in &topology.cuts {
            for constraint in topology.joint_types[cut.joint].constraints() {
                let (path, is_angle) = (cut.path.clone(), constraint.is_moment());
                rows.push(Row { path, is_angle, gearing: None });
            }
        }
        for (index, gearing) in topology.gearings.iter().enumerate() {
            rows.push(Row {
                path: gearing.nodes.iter().map(|&node| (node, 1.0)).collect(),
                is_angle: !gearing.is_length,
                gearing: Some(index),
            });
        }
        let closures = rows.len();
        for &coordinate in coordinates {
            rows.push(Row {
                path: measure::path(topology, coordinate),
                is_angle: coordinate.is_angle(&topology.joint_types),
                gearing: None,
            });
        }
        for spin in spins {
            let path = topology.ancestors(spin.body.0).into_iter().map(|n| (n, 1.0)).collect();
            rows.push(Row { path, is_angle: true, gearing: None });
        }
        let mut entries = Vec::new();
        for (row, content) in rows.iter().enumerate() {
            for &(node, _) in &content.path {
                let tree_dofs = topology.nodes[node].tree_dofs.clone();
                entries.extend(tree_dofs.map(|column| Entry { row, column }));
            }
        }
        Self {
            rows,
            closures,
            coordinates: coordinates.to_vec(),
            orientations: coordinates.iter().map(|&c| orientation(coordinates, c)).collect(),
            differences: coordinates.iter().map(|&c| measure::difference(topology, c)).collect(),
            spins: spins.to_vec(),
            entries,
        }
    }

    /// Returns the prescribed coordinates.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// For each prescribed coordinate that is an angle of a spanning-tree joint, yields the index
    /// of the angle among the spanning tree's coordinates; otherwise `None`. These angles count
    /// full turns, which poses cannot reveal.
    pub fn tree_angles<'a>(
        &'a self,
        topology: &'a Topology,
    ) -> impl Iterator<Item = Option<usize>> + 'a {
        self.coordinates.iter().map(|coordinate| measure::tree_angle(topology, *coordinate))
    }

    /// Returns the passive spins whose rate is set to zero.
    pub fn spins(&self) -> &[Spin] {
        &self.spins
    }

    /// Returns the row and column indices of the system's structural nonzeros, in row order.
    pub(super) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the number of rows of the system.
    pub(super) fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Yields a flag for each row: `true` if its error is an angle, `false` if it is a length.
    pub(super) fn are_angles(&self) -> impl Iterator<Item = bool> + '_ {
        self.rows.iter().map(|row| row.is_angle)
    }

    /// Returns a factor for each row that makes errors of angles and lengths comparable: 1 for
    /// angles, `1 / length` for lengths, with the characteristic length `length` in m.
    pub(super) fn row_scales(&self, length: f64) -> Vec<f64> {
        self.rows.iter().map(|row| if row.is_angle { 1.0 } else { 1.0 / length }).collect()
    }
}

/// Returns the indices of all three components of a rotation vector among `coordinates` if
/// `coordinate` is one of them and all three are prescribed. If all three are prescribed, the
/// angle of the rotation vector may exceed half a turn.
fn orientation(coordinates: &[Coordinate], coordinate: Coordinate) -> Option<[usize; 3]> {
    let Coordinate::RotationVector { body, .. } = coordinate else { return None };
    let place =
        |axis| coordinates.iter().position(|c| *c == Coordinate::RotationVector { body, axis });
    Some([place(0)?, place(1)?, place(2)?])
}
