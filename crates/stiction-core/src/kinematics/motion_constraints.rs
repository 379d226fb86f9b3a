//! Which motion is prescribed: the rows of the linear system of [`super::system`], and where its numbers stand.

use super::coordinate::Coordinate;
use super::measure::{self, Difference};
use crate::linalg::Entry;
use crate::mechanism::BodyId;
use crate::spatial::Vec3;
use crate::topology::Topology;

/// Which motion is prescribed, and how.
#[derive(Clone, Debug)]
pub struct MotionConstraints {
    pub(super) rows: Vec<Row>,
    /// Rows before this one are constraints of cut joints.
    pub(super) closures: usize,
    pub(super) coordinates: Vec<Coordinate>,
    /// For parts of whole rotation vectors, where all three parts stand.
    pub(super) orientations: Vec<Option<[usize; 3]>>,
    pub(super) differences: Vec<Difference>,
    pub(super) spins: Vec<Spin>,
    pub(super) entries: Vec<Entry>,
}

/// A row of the system: whose motion it measures, as nodes and signs.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) path: Vec<(usize, f64)>,
    /// Whether its error is an angle rather than a length.
    pub(super) is_angle: bool,
}

/// A rotation of one body about an axis of its own that neither the motion nor the loops
/// determine, such as that of a rod between two balls. By convention the body does not spin; the
/// dynamics determine with what acceleration it would begin to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// The body.
    pub body: BodyId,
    /// Unit vector in the body's axes.
    pub axis: Vec3<f64>,
}

impl MotionConstraints {
    /// Prescribes `coordinates`, and that the bodies in `spins` do not spin.
    pub fn new(topology: &Topology, coordinates: &[Coordinate], spins: &[Spin]) -> Self {
        let mut rows = Vec::new();
        for cut in &topology.cuts {
            for constraint in topology.joint_types[cut.joint].constraints() {
                rows.push(Row { path: cut.path.clone(), is_angle: constraint.is_moment() });
            }
        }
        let closures = rows.len();
        for &coordinate in coordinates {
            rows.push(Row {
                path: measure::path(topology, coordinate),
                is_angle: coordinate.is_angle(&topology.joint_types),
            });
        }
        for spin in spins {
            let path = topology.ancestors(spin.body.0).into_iter().map(|n| (n, 1.0)).collect();
            rows.push(Row { path, is_angle: true });
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

    /// The prescribed coordinates.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// For each of them the place among the tree's coordinates, if it is an angle of a joint there. Such an angle goes on
    /// over whole turns, which poses do not tell.
    pub fn tree_angles<'a>(
        &'a self,
        topology: &'a Topology,
    ) -> impl Iterator<Item = Option<usize>> + 'a {
        self.coordinates.iter().map(|coordinate| measure::tree_angle(topology, *coordinate))
    }

    /// The spins that are held.
    pub fn spins(&self) -> &[Spin] {
        &self.spins
    }

    /// Where the system has numbers, row by row.
    pub(super) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Number of rows.
    pub(super) fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// For each row whether its error is an angle rather than a length.
    pub(super) fn are_angles(&self) -> impl Iterator<Item = bool> + '_ {
        self.rows.iter().map(|row| row.is_angle)
    }

    /// Factors that make errors of angles and lengths comparable: lengths count in units of
    /// `length`.
    pub(super) fn row_scales(&self, length: f64) -> Vec<f64> {
        self.rows.iter().map(|row| if row.is_angle { 1.0 } else { 1.0 / length }).collect()
    }
}

/// Where the whole rotation vector stands among the coordinates, if `coordinate` is a part of one
/// that is prescribed with all its parts. Then it may go beyond half a turn.
fn orientation(coordinates: &[Coordinate], coordinate: Coordinate) -> Option<[usize; 3]> {
    let Coordinate::RotationVector { body, .. } = coordinate else { return None };
    let place =
        |axis| coordinates.iter().position(|c| *c == Coordinate::RotationVector { body, axis });
    Some([place(0)?, place(1)?, place(2)?])
}
