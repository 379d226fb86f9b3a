//! Numbers of base parameters.

use super::robots::*;
use nalgebra::{DMatrix, DVector};
use stiction_core::Vec3;
use stiction_core::linalg::Svd;
use stiction_core::mechanism::Mechanism;
use stiction_core::random::Random;
use stiction_format::gallery;
use stiction_identify::{BaseParameters, Choice, Parameter, Regressor};

fn inertia() -> Choice {
    Choice { friction: false, ..Choice::ALL }
}

fn rank(mechanism: &Mechanism) -> BaseParameters {
    rank_of(mechanism, inertia())
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

/// Planar 2R arm: the reduced moment zz of both links and two first moments of each. Gravity adds
/// no combination, but it separates the first moments of link 1 from its inertia.
#[test]
fn planar_2r_has_six_or_four() {
    let rows = [(0.0, 0.4, 0.0), (0.0, 0.3, 0.0)];
    assert_eq!(rank(&serial(&rows, Vec3::new(0.0, -9.81, 0.0))).rank(), 6);
    assert_eq!(rank(&serial(&rows, Vec3::new(0.0, 0.0, -9.81))).rank(), 4);
}

/// PUMA 560: 36 inertial base parameters without motors, and 40 with the inertias of its motors, of
/// which those of the first two axes are combined with inertias of links (Gautier, Khalil 1990).
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
    let at_motors = Choice { at_motors: true, ..inertia() };
    assert_eq!(rank_of(&serial_with_motors(&rows, gravity), at_motors).rank(), 40);
}

/// Gallery robots whose efforts do not follow from a motion, because they are singular.
const WITHOUT_EFFORTS: [&str; 3] = ["3upu-singular", "griffis-duffy", "zhang2018"];

/// Matrix of columns for random motions near the first configuration of the default motion.
fn columns(name: &str, seed: u64) -> Option<(DMatrix<f64>, Vec<Parameter>)> {
    let model = gallery_model(name);
    let (solver, home) = gallery_solver(&model);
    let mut regressor = Regressor::new(solver, &inertia()).ok()?;
    let parameters = regressor.parameters().to_vec();
    let size = 0.1 * model.mechanism.characteristic_length().min(1.0);
    let mut random = Random::new(seed);
    let mut all = Vec::new();
    // Several rows for each parameter.
    let count = 4 * parameters.len() / home.len() + 20;
    // A single coordinate moves through a full turn, or back where it cannot continue. The columns
    // are smooth functions of the configuration, so a short arc hardly distinguishes their
    // combinations (singular values of 1e-13 for half a radian, of 1e-5 for a full turn).
    let (mut turned, mut step) = (home[0], std::f64::consts::TAU / (4 * count) as f64);
    for _ in 0..8 * count {
        let [mut q, v, a] = random_motion(&mut random, &home, size);
        if let [q] = &mut q[..] {
            turned += step;
            *q = turned;
        }
        let found = regressor.at(&q, &v, &a);
        if found.is_err() {
            turned -= step;
            step = -step;
        }
        // For a single coordinate, only about half of the configurations are used.
        if home.len() > 1 || random.number() > 0.5 {
            all.extend(found.ok());
        }
        if all.len() == count {
            break;
        }
    }
    assert_eq!(all.len(), count, "{name}: too few positions are reached");
    Some((stacked(&all), parameters))
}

/// For every gallery robot, the combinations span the row space of the columns at other random
/// motions, which is found by singular value decomposition.
#[test]
fn every_gallery_robot_against_singular_values() {
    let (mut refused, mut apart) = (Vec::new(), Vec::new());
    for name in gallery::names() {
        let Some((matrix, parameters)) = columns(name, 3) else {
            refused.push(name);
            continue;
        };
        let base = BaseParameters::of(&matrix, &parameters);
        let (other, _) = columns(name, 11).unwrap();
        let norms: Vec<f64> = other.column_iter().map(|c| c.norm()).collect();
        let largest = norms.iter().copied().fold(0.0, f64::max);
        let mut scaled = other.clone();
        for (mut column, norm) in scaled.column_iter_mut().zip(&norms) {
            // A column of round-off errors has no effect.
            column.scale_mut(if *norm > 1e-10 * largest { norm.recip() } else { 0.0 });
        }
        let svd = Svd::new(&scaled.qr().r());
        let values: Vec<f64> = svd.singular_values.iter().copied().collect();
        let expected = values.iter().filter(|s| **s > 1e-8 * values[0]).count();
        if base.rank() != expected || base.gap <= 1e8 {
            apart.push(format!("{name}: {} {expected} {} {values:?}", base.rank(), base.gap));
            continue;
        }
        let mut worst = 0.0_f64;
        // Every combination, written as a row over scaled parameters, lies in the row space.
        for combination in &base.combinations {
            let mut row = DVector::zeros(parameters.len());
            row[combination.leader] = norms[combination.leader].recip();
            for (k, c) in &combination.others {
                row[*k] = c * norms[*k].recip();
            }
            // In scaled columns x = norm * theta, a combination beta = row . x.
            let row = row.normalize();
            let mut outside = row.clone();
            for k in 0..expected {
                let column = svd.v.column(k);
                outside.axpy(-column.dot(&row), &column, 1.0);
            }
            worst = worst.max(outside.norm());
        }
        // Sine of the angle to the row space. If two spaces have the same dimension and each row of
        // one lies in the other, they are equal. Loops are closed to 1e-12, which the condition
        // number of the columns multiplies.
        let condition = values[0] / values[expected - 1];
        if worst >= 1e-8 {
            apart.push(format!("{name}: {worst:e}, condition {condition:e}"));
        }
    }
    assert_eq!(refused, WITHOUT_EFFORTS);
    assert!(apart.is_empty(), "{apart:#?}");
}
