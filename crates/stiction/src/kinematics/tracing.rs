//! What a mechanism can really do from a position: motions of finite size, traced.

use super::bodies::State;
use super::system::{Kinematics, Prescription, column_scales};
use crate::linalg::{Elimination, Svd};
use crate::parameters::Parameters;
use crate::topology::Topology;
use nalgebra::{DMatrix, DVector};

/// Size of the steps, angles in radians, lengths in units of the characteristic length. What is
/// blocked to second order comes back from them to the square root of what counts as closed.
const STEP: f64 = 1e-3;
/// Loops closed better than this count as closed.
const CLOSED: f64 = 1e-13;
/// Steps of the way back onto closed loops.
const CORRECTIONS: usize = 400;
/// Of directions of length one, what is left after closing the loops: more than this is motion,
/// less is the bend of a motion (some [`STEP`]) or the rest of a blocked one (some 1e-3).
const MOVES: f64 = 0.05;

/// The loops of a mechanism, nothing prescribed.
struct Loops<'a> {
    topology: &'a Topology,
    parameters: &'a Parameters<f64>,
    prescription: Prescription,
    kinematics: Kinematics<f64>,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

/// The singular values of the loops' equations at a position, largest first, one for each freedom
/// of the tree.
pub(crate) fn singular_values(
    topology: &Topology,
    parameters: &Parameters<f64>,
    state: &State<f64>,
) -> Vec<f64> {
    Loops::new(topology, parameters).svd(state).singular_values.as_slice().to_vec()
}

/// The number of independent motions of finite size from a position, by tracing them: from a
/// generic position nearby steps in all directions that are open to first order are taken, the
/// loops closed again, and what is left of the steps is counted. `negligible` decides ranks.
pub(crate) fn finite_mobility(
    topology: &Topology,
    parameters: &Parameters<f64>,
    state: &State<f64>,
    negligible: f64,
) -> usize {
    let mut loops = Loops::new(topology, parameters);
    let svd = loops.svd(state);
    let rank = if svd.largest() == 0.0 { 0 } else { svd.rank(negligible) };
    let open = svd.null_space(rank);
    // Where all equations are independent every motion to first order is one of finite size.
    if open.is_empty() || rank == topology.constraints {
        return open.len();
    }
    let mut random = Directions(1);
    // Where branches of motion meet more is open than along any of them: away from there first,
    // by the way on which most is left.
    let mut generic = state.clone();
    let mut farthest = 0.0;
    for _ in 0..2 * open.len() + 6 {
        let step = random.within(&open) * (10.0 * STEP);
        if let Some((reached, moved)) = loops.step(state, &step)
            && moved.norm() > farthest
        {
            farthest = moved.norm();
            generic = reached;
        }
    }
    let svd = loops.svd(&generic);
    // Positions are closed to 1e-13, singular values of a double root to its square root.
    let open = svd.null_space(svd.rank(negligible.max(1e-6)));
    let mut left = Vec::new();
    for _ in 0..2 * open.len() + 6 {
        let step = random.within(&open) * STEP;
        if let Some((_, moved)) = loops.step(&generic, &step) {
            left.push(moved / STEP);
        }
    }
    if left.is_empty() {
        return 0;
    }
    let count = left.len() as f64;
    let spread = Svd::new(&DMatrix::from_columns(&left).transpose());
    let limit = MOVES * count.sqrt();
    spread.singular_values.iter().filter(|&&value| value > limit).count()
}

impl<'a> Loops<'a> {
    fn new(topology: &'a Topology, parameters: &'a Parameters<f64>) -> Self {
        let prescription = Prescription::new(topology, &[], &[]);
        let kinematics = Kinematics::new(topology, &prescription, &Elimination::default());
        let rows = prescription.row_scales(parameters.length);
        let columns = column_scales(topology, parameters.length);
        Self { topology, parameters, prescription, kinematics, rows, columns }
    }

    /// Places the bodies; the loops' errors, scaled.
    fn errors(&mut self, state: &State<f64>) -> DVector<f64> {
        self.kinematics.place(self.topology, self.parameters, &self.prescription, state, &[]);
        let errors = self.kinematics.errors().iter().zip(&self.rows).map(|(e, s)| e * s);
        DVector::from_iterator(self.rows.len(), errors)
    }

    /// The scaled derivatives of the errors where the bodies were placed last.
    fn jacobian(&mut self) -> DMatrix<f64> {
        self.kinematics.linearise(self.topology, &self.prescription);
        let mut jacobian = DMatrix::zeros(self.rows.len(), self.columns.len());
        for (entry, value) in self.prescription.entries().iter().zip(&self.kinematics.entries) {
            jacobian[(entry.row, entry.column)] +=
                value * self.rows[entry.row] * self.columns[entry.column];
        }
        jacobian
    }

    fn svd(&mut self, state: &State<f64>) -> Svd {
        self.errors(state);
        Svd::new(&self.jacobian())
    }

    /// Takes a step (scaled rates) and closes the loops again by the shortest ways; where that leads
    /// and how far in all, if anywhere.
    fn step(
        &mut self,
        from: &State<f64>,
        step: &DVector<f64>,
    ) -> Option<(State<f64>, DVector<f64>)> {
        let mut state = from.clone();
        let mut moved = step.clone();
        self.advance(&mut state, step);
        let mut errors = self.errors(&state);
        let mut damping = 1e-12;
        for _ in 0..CORRECTIONS {
            if errors.amax() < CLOSED {
                return Some((state, moved));
            }
            let jacobian = self.jacobian();
            let normal = &jacobian * jacobian.transpose();
            // Equations that depend on each other are damped, the others hardly.
            let mut damped = normal.clone();
            (0..damped.nrows()).for_each(|i| damped[(i, i)] += damping);
            let Some(factor) = damped.cholesky() else {
                damping *= 100.0;
                continue;
            };
            let correction = -jacobian.tr_mul(&factor.solve(&errors));
            let mut next = state.clone();
            self.advance(&mut next, &correction);
            let next_errors = self.errors(&next);
            if next_errors.norm() < errors.norm() {
                (state, errors) = (next, next_errors);
                moved += correction;
                damping = (damping * 0.1).max(1e-16);
            } else {
                self.errors(&state);
                damping *= 100.0;
                if damping > 1e3 {
                    break;
                }
            }
        }
        None
    }

    fn advance(&self, state: &mut State<f64>, step: &DVector<f64>) {
        let step: Vec<f64> = step.iter().zip(&self.columns).map(|(s, c)| s * c).collect();
        state.advance(self.topology, &step);
    }
}

/// Directions that are the same in every run (Knuth's linear congruential generator).
struct Directions(u64);

impl Directions {
    fn number(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A combination of orthonormal vectors of length one.
    fn within(&mut self, basis: &[DVector<f64>]) -> DVector<f64> {
        let mut sum = DVector::zeros(basis[0].len());
        for vector in basis {
            sum.axpy(self.number(), vector, 1.0);
        }
        let size = sum.norm();
        if size > 0.0 { sum / size } else { basis[0].clone() }
    }
}
