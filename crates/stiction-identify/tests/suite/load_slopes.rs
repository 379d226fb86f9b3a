//! Derivatives of normal loads compared with differences of solutions.

use super::robots::*;
use stiction_core::random::Random;
use stiction_format::{Source, read};
use stiction_identify::{Choice, Kind, LoadSlopes, Regressor};

/// Drive with laws that no gallery model has: a thread, whose normal load depends on its own friction, a guide with
/// Stribeck's curve and a preload, and a bearing with another law for backward sliding.
const DRIVE: &str = r#"
gravity = ["3 m/s^2", "-2 m/s^2", "-9 m/s^2"]

[bodies.screw]
mass = "1.2 kg"
com = ["10 mm", "5 mm", "20 mm"]
inertia = [0.1, 0.1, 0.1]

[bodies.nut]
mass = "2.3 kg"
com = ["30 mm", "-20 mm", "0 mm"]
inertia = [0.1, 0.1, 0.1]

[joints.motor]
type = "R"
from = "ground"
to = "screw"
axis = "z"
actuated = true
friction = { mu = 0.1, radius = "5 mm", backward = { mu = 0.2 } }

[joints.thread]
type = "H"
from = "screw"
to = "nut"
axis = "z"
pitch = "5 mm"
friction = { mu = 0.15, radius = "5.5 mm", flank_angle = "30 deg" }

[joints.guide]
type = "P"
from = "ground"
to = "nut"
axis = "z"
friction = { mu = 0.2, mu_static = 0.3, stribeck_velocity = "5 mm/s", preload = "4 N" }
"#;

/// Gallery models with a friction coefficient, and [`DRIVE`].
fn regressors() -> impl Iterator<Item = (&'static str, Vec<f64>, Regressor)> {
    let model = read(&Source::new("drive.toml", DRIVE), &|_| Err("no files".into())).unwrap();
    let coordinates = actuator_coordinates(&model.mechanism);
    let solver = solver(&model.mechanism, &coordinates, &[0.3]);
    let choice = Choice { static_excess: true, ..Choice::ALL };
    let drive = ("drive", vec![0.3], Regressor::new(solver, &choice).unwrap());
    let all = gallery_regressors().chain([drive]);
    all.filter(|(.., own)| own.parameters().iter().any(|p| matches!(p.kind, Kind::Mu(_))))
}

/// Checks derivatives with respect to each parameter of friction or of a body, and to all coefficients together, while joints slide in
/// both directions.
#[test]
fn derivatives_of_loads_are_those_of_differences() {
    let mut tried = 0;
    for (name, home, mut regressor) in regressors() {
        let mut random = Random::new(17);
        let [q, v, a] = random_motion(&mut random, &home, 0.02);
        let back: Vec<f64> = v.iter().map(|rate| -rate).collect();
        for v in [v, back] {
            if regressor.at(&q, &v, &a).is_ok() {
                tried += usize::from(compare(name, &regressor, [&q, &v, &a]));
            }
        }
    }
    assert!(tried >= 10, "{tried}");
}

/// Compares the derivatives at one instant; returns false if the forces have no solution.
fn compare(name: &str, regressor: &Regressor, [q, v, a]: [&[f64]; 3]) -> bool {
    let parameters = regressor.parameters();
    // Load-independent friction is represented by a preload, which a law without friction
    // coefficient cannot carry.
    let values: Vec<f64> = parameters
        .iter()
        .map(|p| match p.kind {
            Kind::Coulomb(_) => p.prior + 0.02,
            Kind::Viscous(_) => p.prior + 0.01,
            Kind::Mu(_) => 0.8 * p.prior,
            _ => p.prior,
        })
        .collect();
    let all = 0..parameters.len();
    let is_moved = |k: &usize| {
        let own = &parameters[*k];
        own.kind.interface().is_some() || own.body().is_some()
    };
    let mut groups: Vec<Vec<usize>> = all.clone().filter(is_moved).map(|k| vec![k]).collect();
    groups.push(all.filter(|&k| matches!(parameters[k].kind, Kind::Mu(_))).collect());
    let loads = |values: &[f64]| -> Vec<f64> {
        let engine = regressor.engine_parameters(values);
        let mut data = regressor.engine_data();
        regressor.loads(&engine, &mut data, [q, v, a]).unwrap().loads
    };
    let engine = regressor.engine_parameters(&values);
    let mut data = regressor.engine_data();
    let Ok(solved) = regressor.loads(&engine, &mut data, [q, v, a]) else { return false };
    let preloads = engine.interfaces.iter().map(|i| i.load.preload);
    let whole = solved.loads.iter().zip(preloads).map(|(load, preload)| (load + preload).abs());
    let largest = whole.fold(0.0, f64::max);
    let found = LoadSlopes::new(regressor, &groups).at(&solved, (&engine, &data)).unwrap();
    for (column, group) in groups.iter().enumerate() {
        let step = 1e-4 * parameters[group[0]].scale.min(1.0);
        let changed = |by: f64| {
            let mut changed = values.clone();
            group.iter().for_each(|&k| changed[k] += by);
            loads(&changed)
        };
        let [a, b, c, d] = [1.0, -1.0, 2.0, -2.0].map(|part| changed(part * step));
        for (i, found) in found.column(column).iter().enumerate() {
            let expected = (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * step);
            // Fourth-order differences. Their round-off is that of loads and preloads divided by
            // the step; preloads of laws without coefficient are 10^9 times their friction.
            let preload = engine.interfaces[i].load.preload;
            let round_off = 1e-12 * (largest + preload) / step;
            let error = (found - expected).abs();
            assert!(
                error <= 1e-6 * expected.abs() + round_off,
                "{name}: {} on interface {i}: {found} {expected}",
                parameters[group[0]].name,
            );
        }
    }
    true
}
