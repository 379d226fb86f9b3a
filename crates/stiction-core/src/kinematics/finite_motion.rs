//! Finite motion of a mechanism, as evidence of its finite mobility.
//!
//! Equation (M3) of the book's theory.

use super::bodies::{Bodies, State};
use super::tracing::Loops;
use nalgebra::DVector;

/// Size of a step along the motion, in rad and characteristic lengths.
const STRIDE: f64 = 0.05;
/// Maximum number of steps along the motion.
const STRIDES: usize = 20;
/// Maximum number of corrections of the loop errors after each step.
const CORRECTIONS: usize = 8;
/// Damping of the corrections; it suppresses singular values below 1e-6.
const DAMPING: f64 = 1e-12;
/// Largest permitted scaled loop error along the motion. This tolerance admits dimensions given
/// with six digits.
const OPEN: f64 = 1e-6;
/// The motion ends if the component of a corrected step along the previous direction is less than
/// this fraction of [`STRIDE`].
const REMAINS: f64 = 0.5;

/// A motion of a mechanism over a finite distance.
#[derive(Clone, Debug, PartialEq)]
pub struct FiniteMotion {
    /// The body that moves farthest.
    pub body: String,
    /// Displacement of the origin of [`Self::body`], m.
    pub moved: f64,
    /// Rotation of [`Self::body`], rad.
    pub turned: f64,
    /// Largest loop error along the motion, in rad and characteristic lengths.
    pub closure: f64,
}

/// Last state of a traced motion, with the length of the path and the largest loop error along the
/// path, both in rad and characteristic lengths.
pub(super) struct Path {
    pub(super) state: State<f64>,
    pub(super) length: f64,
    pub(super) closure: f64,
}

impl Loops<'_> {
    /// Traces a motion from the state `from` in the scaled `direction` while the loop errors stay
    /// within [`OPEN`]. Exact closure is not required, because dimensions with few digits make an
    /// overconstrained mechanism strictly rigid.
    pub(super) fn follow(&mut self, from: &State<f64>, direction: &DVector<f64>) -> Path {
        let mut path = Path { state: from.clone(), length: 0.0, closure: 0.0 };
        let mut heading = direction.normalize();
        for _ in 0..STRIDES {
            let Some((state, moved, closure)) = self.stride(&path.state, &(&heading * STRIDE))
            else {
                break;
            };
            let length = moved.norm();
            if closure > OPEN || moved.dot(&heading) < REMAINS * STRIDE || length > 2.0 * STRIDE {
                break;
            }
            path.closure = path.closure.max(closure);
            path.length += length;
            path.state = state;
            heading = moved.normalize();
        }
        path
    }

    /// Takes a step, then reduces the loop errors as far as possible by minimum-norm corrections.
    /// Returns the state, the total displacement (scaled) and the largest loop error; `None` if a
    /// correction cannot be computed.
    fn stride(
        &mut self,
        from: &State<f64>,
        step: &DVector<f64>,
    ) -> Option<(State<f64>, DVector<f64>, f64)> {
        let (mut state, mut moved) = (from.clone(), step.clone());
        self.advance(&mut state, step);
        let mut errors = self.errors(&state);
        for _ in 0..CORRECTIONS {
            let jacobian = self.jacobian();
            let correction = self.damped.step(&jacobian, &errors, DAMPING)?;
            let mut next = state.clone();
            self.advance(&mut next, &correction);
            let next_errors = self.errors(&next);
            if next_errors.norm().is_nan() || next_errors.norm() >= errors.norm() {
                self.errors(&state);
                break;
            }
            (state, errors) = (next, next_errors);
            moved += correction;
        }
        Some((state, moved, errors.amax()))
    }
}

/// Finds the body with the largest displacement from placement `a` to placement `b`. Returns the
/// index of the body, the displacement of its origin (m) and its rotation (rad).
pub(super) fn farthest(a: &Bodies<f64>, b: &Bodies<f64>, length: f64) -> Option<(usize, f64, f64)> {
    let each = a.pose.iter().zip(&b.pose).enumerate().skip(1).map(|(body, (a, b))| {
        let apart = a.inverse() * *b;
        (body, apart.position.norm(), apart.rotation.rotation_vector().norm())
    });
    let size = |moved: f64, turned: f64| (moved / length).hypot(turned);
    each.max_by(|a, b| size(a.1, a.2).total_cmp(&size(b.1, b.2)))
}
