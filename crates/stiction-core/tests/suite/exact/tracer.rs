//! An independent computation of finite mobility. Bodies have six coordinates each, joint
//! conditions are written from geometry, derivatives are differences, the joints are closed by a
//! different method, and the dimension is counted at the ends of paths twice as far from the drawn
//! configuration.

use super::{Drawing, Ints};
use crate::common::random::Random;
use nalgebra::{DMatrix, DVector};
use stiction_core::joint::JointType::*;
use stiction_core::linalg::Svd;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Closure tolerance of the joints. A motion blocked at second order then still has displacements
/// of about 1e-6.
const CLOSED: f64 = 1e-13;
/// Size of the first step away from the drawn configuration, then of the steps along a path (rad,
/// units of length).
const STEPS: [f64; 5] = [0.02, 0.04, 0.04, 0.05, 0.05];
/// Size of the steps that count the dimension. If branches intersect in the drawn configuration, at
/// a distance of about 0.2, they bend by about 0.02 of this step.
const PROBE: f64 = 0.004;
/// Limits of the components of a counting step: above the larger limit, a component is a motion;
/// below the smaller limit, it is not; in between, the tracer gives no result.
const MOTION: (f64, f64) = (0.06, 0.25);

/// Result of tracing from the drawn configuration.
#[derive(Clone, Debug, Default)]
pub struct Traced {
    /// Distinct dimensions of the motion branches found, sorted.
    pub dimensions: Vec<usize>,
    /// True if a count was ambiguous, or if there was no count.
    pub doubtful: bool,
    /// Number of paths that were not followed to their ends.
    pub lost: usize,
}

/// End of a traced path.
enum Away {
    There(State),
    /// Closing the joints cancelled the first step.
    Back,
    Lost,
}

/// Poses of all moving bodies relative to the drawn configuration.
type State = Vec<Pose<f64>>;

pub struct Tracer<'a> {
    drawing: &'a Drawing,
    random: Random,
}

impl<'a> Tracer<'a> {
    pub fn new(drawing: &'a Drawing, seed: u64) -> Self {
        Self { drawing, random: Random(seed) }
    }

    /// Leaves the drawn configuration on `ways` different paths and counts the dimension at their
    /// ends.
    pub fn trace(&mut self, ways: usize) -> Traced {
        let start = vec![Pose::identity(); self.drawing.coms.len()];
        let mut traced = Traced::default();
        for _ in 0..ways {
            match self.away(&start) {
                Away::There(there) => {
                    let (dimension, clear) = self.dimension(&there);
                    traced.doubtful |= !clear;
                    traced.dimensions.push(dimension);
                }
                Away::Back => traced.dimensions.push(0),
                Away::Lost => traced.lost += 1,
            }
        }
        // If some paths advance, paths that return to the start give no information.
        if traced.dimensions.iter().any(|&dimension| dimension > 0) {
            traced.dimensions.retain(|&dimension| dimension > 0);
        }
        traced.doubtful |= traced.dimensions.is_empty();
        traced.dimensions.sort_unstable();
        traced.dimensions.dedup();
        traced
    }

    /// Follows one path to a given distance without turning back.
    fn away(&mut self, start: &State) -> Away {
        let mut here = start.clone();
        let mut heading: Option<DVector<f64>> = None;
        for size in STEPS {
            let open = self.open(&here);
            if open.is_empty() {
                return if heading.is_none() { Away::Back } else { Away::Lost };
            }
            let direction = match &heading {
                None => self.within(&open),
                Some(heading) => {
                    let zero = DVector::zeros(heading.len());
                    let along = open.iter().fold(zero, |sum, n| sum + n * n.dot(heading));
                    &along / along.norm()
                }
            };
            let Some((next, moved)) = self.step(&here, &(&direction * size)) else {
                return Away::Lost;
            };
            match moved.norm() / size {
                part if part < MOTION.0 && heading.is_none() => return Away::Back,
                part if !(MOTION.1..3.0).contains(&part) => return Away::Lost,
                _ => {}
            }
            here = next;
            heading = Some(&moved / moved.norm());
        }
        Away::There(here)
    }

    /// Computes the dimension of the reachable set near a configuration, and whether the count is
    /// unambiguous.
    fn dimension(&mut self, here: &State) -> (usize, bool) {
        let open = self.open(here);
        let mut moves = Vec::new();
        for _ in 0..2 * open.len() + 4 {
            let step = self.within(&open) * PROBE;
            if let Some((_, moved)) = self.step(here, &step) {
                moves.push(moved / PROBE);
            }
        }
        if moves.is_empty() {
            return (0, false);
        }
        let scale = (moves.len() as f64 / open.len() as f64).sqrt();
        let spread = Svd::new(&DMatrix::from_columns(&moves).transpose());
        let values = spread.singular_values.iter().map(|value| value / scale);
        let (least, sure) = MOTION;
        let clear = values.clone().all(|value| value < least || value > sure);
        (values.filter(|&value| value > sure).count(), clear)
    }

    fn within(&mut self, basis: &[DVector<f64>]) -> DVector<f64> {
        let mut sum = DVector::zeros(basis[0].len());
        for vector in basis {
            sum.axpy(self.random.signed(), vector, 1.0);
        }
        let size = sum.norm();
        sum / size
    }

    /// Computes a basis of the motions that are open at first order.
    fn open(&self, state: &State) -> Vec<DVector<f64>> {
        let svd = Svd::new(&self.derivatives(state));
        // Differences are accurate to 1e-10; double roots are closed to 1e-6.
        let rank = svd.singular_values.iter().filter(|&&value| value > 1e-5).count();
        svd.null_space(rank)
    }

    /// Takes a step and closes the joints again by damped least squares; returns the total
    /// displacement.
    fn step(&self, from: &State, step: &DVector<f64>) -> Option<(State, DVector<f64>)> {
        let (mut state, mut moved) = (advanced(from, step), step.clone());
        let mut errors = self.errors(&state);
        let mut more = 2.0;
        for _ in 0..1000 {
            if errors.amax() < CLOSED {
                return Some((state, moved));
            }
            // If the displacement returns to the start, closing converges slowly: stop early.
            if errors.amax() < 1e-9 && moved.norm() < 0.5 * MOTION.0 * step.norm() {
                return Some((state, moved));
            }
            let derivatives = self.derivatives(&state);
            let mut normal = derivatives.tr_mul(&derivatives);
            // The damping is proportional to the errors. For `x^2 = 0` and `x y = 0`, undamped
            // steps would go straight to the origin although y is free. Damped steps descend to the
            // line x = 0 and converge fast near it. The damping is not below the rounding of the
            // normal matrix.
            let damping = (more * errors.norm()).max(1e-12);
            (0..normal.nrows()).for_each(|k| normal[(k, k)] += damping);
            let back = -normal.cholesky()?.solve(&derivatives.tr_mul(&errors));
            let next = advanced(&state, &back);
            let next_errors = self.errors(&next);
            if next_errors.norm() < errors.norm() {
                (state, errors) = (next, next_errors);
                moved += back;
                more = (more * 0.5_f64).max(2.0);
            } else {
                more *= 10.0;
            }
        }
        None
    }

    fn derivatives(&self, state: &State) -> DMatrix<f64> {
        // The error of a central difference is of the order of its squared step.
        const H: f64 = 1e-5;
        let columns: Vec<DVector<f64>> = (0..6 * state.len())
            .map(|k| {
                let mut step = DVector::zeros(6 * state.len());
                step[k] = H;
                let ahead = self.errors(&advanced(state, &step));
                (ahead - self.errors(&advanced(state, &-step))) / (2.0 * H)
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// Computes the constraint errors of all joints.
    fn errors(&self, state: &State) -> DVector<f64> {
        let pose = |body: usize| if body == 0 { Pose::identity() } else { state[body - 1] };
        let mut errors = Vec::new();
        for joint in &self.drawing.joints {
            let (p, s) = (pose(joint.ends.0), pose(joint.ends.1));
            let [at, z, x] = [joint.at, joint.axis, joint.second].map(vector);
            let (z, x) = (z * (1.0 / z.norm()), x * (1.0 / x.norm()));
            let y = z.cross(x);
            // Components relative to the predecessor.
            let apart = p.rotation.transpose_mul(s.apply(at) - p.apply(at));
            let turn = p.rotation.transpose() * s.rotation;
            let (dx, dy, dz) = (apart.dot(x), apart.dot(y), apart.dot(z));
            let tilts = [z.dot(turn * x), z.dot(turn * y)];
            let twists = turn.skew_part().to_array();
            match joint.joint_type {
                Revolute => errors.extend([dx, dy, dz, tilts[0], tilts[1]]),
                Prismatic => errors.extend([dx, dy, twists[0], twists[1], twists[2]]),
                Helical => {
                    let angle = y.dot(turn * x).atan2(x.dot(turn * x));
                    errors.extend([dx, dy, tilts[0], tilts[1], dz - joint.pitch as f64 * angle]);
                }
                Cylindrical => errors.extend([dx, dy, tilts[0], tilts[1]]),
                Universal => errors.extend([dx, dy, dz, tilts[0]]),
                Spherical => errors.extend([dx, dy, dz]),
                Planar => errors.extend([dz, tilts[0], tilts[1]]),
                Fixed => errors.extend([dx, dy, dz, twists[0], twists[1], twists[2]]),
                Free => {}
            }
        }
        DVector::from_vec(errors)
    }
}

fn vector(x: Ints) -> Vec3<f64> {
    Vec3::new(x[0] as f64, x[1] as f64, x[2] as f64)
}

/// Applies a small rotation about the origin and a displacement to every body.
fn advanced(state: &State, step: &DVector<f64>) -> State {
    let move_by = |(body, pose): (usize, &Pose<f64>)| {
        let part = |k: usize| Vec3::new(step[k], step[k + 1], step[k + 2]);
        let (turn, shift) = (part(6 * body), part(6 * body + 3));
        let rotation = match turn.norm() {
            0.0 => Mat3::identity(),
            angle => Mat3::rotation(turn, angle),
        };
        Pose { rotation, position: shift } * *pose
    };
    state.iter().enumerate().map(move_by).collect()
}
