//! Forward dynamics of two massless links with a point mass, near positions in which their mass matrix is singular.

#[allow(dead_code)]
mod arm;

use arm::{Code, Math, Params, Real, State};

STD_MATH

fn main() {
    let inexact = if core::mem::size_of::<Real>() == 8 { 1e-11 } else { 1e-4 };
    for straight in [0.0, core::f64::consts::PI] {
        for turned in [0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-3, 0.1, 1.0] {
            let elbow: f64 = straight + turned;
            // Square of the sine: up to a factor near 1, the determinant of the matrix divided by
            // the product of its row and column scales.
            let pivot = elbow.sin().powi(2);
            let (q, qd) = ([0.3, elbow as Real], [0.7, -0.4]);
            let mut state = State::new::<Std>(&q).unwrap();
            let found = state.accelerations::<Std>(&Params::default(), &q, &qd, &[1.0, 0.5]);
            if pivot < inexact / 10.0 {
                assert_eq!(found.unwrap_err(), Code::Singular, "{elbow}");
            } else if pivot > inexact * 10.0 {
                assert!(found.unwrap().iter().all(|a| a.is_finite()), "{elbow}");
            }
        }
    }
}
