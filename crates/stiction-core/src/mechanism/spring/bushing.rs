//! Bushings: elastic connections between frames of two bodies in all six directions.

use super::resolve_ends;
use crate::mechanism::{BodyId, Defect};
use crate::spatial::Pose;
use nalgebra::{Matrix6, SymmetricEigen};
use std::collections::HashMap;

/// Matrix of six rows and six columns, as an array of rows.
pub type SixBySix = [[f64; 6]; 6];

/// An elastic connection with damping between a frame of one body and a frame of another.
///
/// The deflection `x` consists of the displacement of the second frame's origin and the second frame's rotation
/// vector, both relative to the first frame and in the axes of the first frame. The elastic energy is `x K x / 2`; the
/// elastic wrench follows from its gradient. The damping wrench is `-C v`, where `v` are the velocity and the angular
/// velocity of the second frame relative to the first, in the axes of the first frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Bushing {
    /// Name, unique among springs and bushings.
    pub name: String,
    /// The two connected bodies, which are distinct.
    pub ends: [BodyId; 2],
    /// Pose of each of the two connected frames in the frame of its body.
    pub frames: [Pose<f64>; 2],
    /// Stiffness matrix K, symmetric and positive semidefinite. Its rows belong to three forces and
    /// three moments, its columns to three displacements and three rotations. Rows of forces are in
    /// N/m and N/rad, rows of moments in N and N m/rad.
    pub stiffness: SixBySix,
    /// Damping matrix C, symmetric and positive semidefinite, with rows and columns in the order of
    /// [`Self::stiffness`]. Rows of forces are in N s/m and N s/rad, rows of moments in N s and N m
    /// s/rad.
    pub damping: SixBySix,
}

/// Specification of a bushing; it refers to its bodies by name.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct BushingSpec {
    name: String,
    ends: [String; 2],
    frames: [Pose<f64>; 2],
    stiffness: SixBySix,
    damping: SixBySix,
}

impl BushingSpec {
    /// Creates a bushing without stiffness and damping between the frames of two bodies, given by
    /// name.
    pub fn new(name: impl Into<String>, from: impl Into<String>, to: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ends: [from.into(), to.into()],
            frames: [Pose::identity(); 2],
            stiffness: [[0.0; 6]; 6],
            damping: [[0.0; 6]; 6],
        }
    }

    /// Sets the poses of the two frames in their bodies.
    pub fn frames(mut self, from: Pose<f64>, to: Pose<f64>) -> Self {
        self.frames = [from, to];
        self
    }

    /// Sets the stiffness matrix, see [`Bushing::stiffness`].
    pub fn stiffness(mut self, stiffness: SixBySix) -> Self {
        self.stiffness = stiffness;
        self
    }

    /// Sets the damping matrix, see [`Bushing::damping`].
    pub fn damping(mut self, damping: SixBySix) -> Self {
        self.damping = damping;
        self
    }

    pub(in crate::mechanism) fn name(&self) -> &str {
        &self.name
    }

    /// Builds the bushing, or returns `None` if one of its bodies is unknown or both are the same
    /// body. Appends all defects to `defects`.
    pub(in crate::mechanism) fn resolve(
        self,
        ids: &HashMap<String, BodyId>,
        defects: &mut Vec<Defect>,
    ) -> Option<Bushing> {
        for frame in &self.frames {
            let [x, y, z] = frame.rotation.columns;
            if ![x, y, z, frame.position].iter().all(|v| v.is_finite()) {
                let place = format!("a frame of bushing `{}`", self.name);
                defects.push(Defect::NotFinite { place });
            }
        }
        for (what, matrix) in [("stiffness", &self.stiffness), ("damping", &self.damping)] {
            if let Some(problem) = defect_of(matrix) {
                let problem = format!("its {what} matrix {problem}");
                defects.push(Defect::Spring { spring: self.name.clone(), problem });
            }
        }
        let ends = resolve_ends(&self.name, &self.ends, ids, defects)?;
        let Self { name, frames, stiffness, damping, .. } = self;
        Some(Bushing { name, ends, frames, stiffness, damping })
    }
}

/// Returns the part of a message that says why a matrix is not symmetric positive semidefinite, or
/// `None` if the matrix has this property.
fn defect_of(matrix: &SixBySix) -> Option<String> {
    // Entries in files are rounded, so a rotated matrix is rarely exactly symmetric.
    const ROUNDING: f64 = 1e-9;
    if matrix.iter().flatten().any(|x| !x.is_finite()) {
        return Some("contains a number that is not finite".to_owned());
    }
    for i in 0..6 {
        if matrix[i][i] < 0.0 {
            let value = matrix[i][i];
            return Some(format!(
                "has {value} on its diagonal, where all entries must be at least 0"
            ));
        }
    }
    // Scale the diagonal to one, because the entries have different units.
    let scale = |i: usize| if matrix[i][i] > 0.0 { matrix[i][i].sqrt().recip() } else { 1.0 };
    for i in 0..6 {
        for j in 0..i {
            let (a, b) = (matrix[i][j], matrix[j][i]);
            if (a - b).abs() * scale(i) * scale(j) > ROUNDING {
                let (row, column) = (i + 1, j + 1);
                return Some(format!(
                    "is not symmetric: {a} in row {row}, column {column}, but {b} in row {column}, column {row}"
                ));
            }
        }
    }
    let scaled = Matrix6::from_fn(|i, j| 0.5 * (matrix[i][j] + matrix[j][i]) * scale(i) * scale(j));
    let least = SymmetricEigen::new(scaled).eigenvalues.min();
    (least < -ROUNDING).then(|| {
        "has a negative eigenvalue: the off-diagonal entries are too large, so that some \
         deflection would release energy"
            .to_owned()
    })
}
