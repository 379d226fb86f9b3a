//! Numbers of base parameters.

use super::robots::*;
use stiction_core::Vec3;
use stiction_core::linalg::Svd;
use stiction_core::mechanism::Mechanism;
use stiction_identify::{BaseParameters, Choice};

const INERTIA: Choice = Choice { friction: false, ..Choice::ALL };

fn rank(mechanism: &Mechanism) -> BaseParameters {
    rank_of(mechanism, INERTIA)
}

fn rank_of(mechanism: &Mechanism, choice: Choice) -> BaseParameters {
    let coordinates = actuator_coordinates(mechanism);
    let home = vec![0.3; coordinates.len()];
    let (regressor, all) =
        random_columns(solver(mechanism, &coordinates, &home), choice, &home, (3.0, 60));
    let base = BaseParameters::of(&stacked(&all), regressor.parameters());
    assert!(base.gap > 1e4, "gap {}", base.gap);
    base
}

/// Planar 2R arm: zz of both links reduced, two first moments of each; gravity adds no combination but
/// separates the first moments of link 1 from its inertia.
#[test]
fn planar_2r_has_six_or_four() {
    let rows = [(0.0, 0.4, 0.0), (0.0, 0.3, 0.0)];
    assert_eq!(rank(&serial(&rows, Vec3::new(0.0, -9.81, 0.0))).rank(), 6);
    assert_eq!(rank(&serial(&rows, Vec3::new(0.0, 0.0, -9.81))).rank(), 4);
}

/// PUMA 560: 36 inertial base parameters, and 40 with the inertias of its motors, of which those of the
/// first two axes join the inertias of links (Gautier, Khalil 1990).
#[test]
fn puma_560_has_36_and_40() {
    use std::f64::consts::FRAC_PI_2 as Q;
    let gravity = Vec3::new(0.0, 0.0, -9.81);
    let rows = [
        (0.0, 0.0, Q),
        (0.0, 0.4318, 0.0),
        (0.15, 0.0203, -Q),
        (0.4318, 0.0, Q),
        (0.0, 0.0, -Q),
        (0.0, 0.0, 0.0),
    ];
    assert_eq!(rank(&serial(&rows, gravity)).rank(), 36);
    let at_motors = Choice { at_motors: true, ..INERTIA };
    assert_eq!(rank_of(&serial_with_motors(&rows, gravity), at_motors).rank(), 40);
}

/// The span of the combinations equals the row space of the columns, by an independent singular value
/// decomposition, for closed chains of the gallery.
#[test]
fn closed_chains_against_singular_values() {
    for name in ["3rps", "five-bar", "delta", "slider-crank", "four-bar", "gough"] {
        let model = gallery_model(name);
        let (solver, home) = gallery_solver(&model);
        let (regressor, all) = random_columns(solver, INERTIA, &home, (0.05, 80));
        let matrix = stacked(&all);
        let parameters = regressor.parameters();
        let base = BaseParameters::of(&matrix, parameters);
        let norms: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
        let largest = norms.iter().copied().fold(0.0, f64::max);
        let mut scaled = matrix.clone();
        for (mut column, norm) in scaled.column_iter_mut().zip(&norms) {
            // A column of round-off has no effect.
            column.scale_mut(if *norm > 1e-10 * largest { norm.recip() } else { 0.0 });
        }
        let svd = Svd::new(&scaled.clone().qr().r());
        let values: Vec<f64> = svd.singular_values.iter().copied().collect();
        let expected = values.iter().filter(|s| **s > 1e-8 * values[0]).count();
        assert_eq!(base.rank(), expected, "{name}: {values:?}");
        // Principal angles: every combination, as a row over scaled parameters, lies in the row space.
        for combination in &base.combinations {
            let mut row = nalgebra::DVector::zeros(parameters.len());
            row[combination.leader] = norms[combination.leader].recip();
            for (k, c) in &combination.others {
                row[*k] = c * norms[*k].recip();
            }
            // In scaled columns x = norm * theta, a combination beta = row . x.
            let row = row.normalize();
            let inside: f64 = (0..expected).map(|k| svd.v.column(k).dot(&row).powi(2)).sum();
            assert!((1.0 - inside).max(0.0).sqrt() < 1e-6, "{name}: {}", 1.0 - inside);
        }
    }
}
