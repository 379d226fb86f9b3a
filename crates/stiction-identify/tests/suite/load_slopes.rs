//! Derivatives of normal loads compared with differences of solutions.

use super::robots::*;
use stiction_core::random::Random;
use stiction_identify::{Kind, LoadSlopes};

/// Checks derivatives with respect to all friction parameters of each gallery model that has a
/// friction coefficient.
#[test]
fn derivatives_of_loads_are_those_of_differences() {
    let mut tried = 0;
    for (name, home, mut regressor) in gallery_regressors() {
        let parameters = regressor.parameters().to_vec();
        if !parameters.iter().any(|p| matches!(p.kind, Kind::Mu(_))) {
            continue;
        }
        let mut random = Random::new(17);
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
        let is_moved = |k: &usize| parameters[*k].kind.interface().is_some();
        let groups: Vec<Vec<usize>> =
            (0..parameters.len()).filter(is_moved).map(|k| vec![k]).collect();
        let [q, v, a] = random_motion(&mut random, &home, 0.02);
        if regressor.at(&q, &v, &a).is_err() {
            continue;
        }
        let loads = |values: &[f64]| -> Vec<f64> {
            let engine = regressor.engine_parameters(values);
            let mut data = regressor.engine_data();
            regressor.loads(&engine, &mut data, [&q, &v, &a]).unwrap().loads
        };
        let engine = regressor.engine_parameters(&values);
        let mut data = regressor.engine_data();
        let Ok(solved) = regressor.loads(&engine, &mut data, [&q, &v, &a]) else { continue };
        tried += 1;
        let preloads = engine.interfaces.iter().map(|i| i.load.preload);
        let whole = solved.loads.iter().zip(preloads).map(|(load, preload)| (load + preload).abs());
        let largest = whole.fold(0.0, f64::max);
        let found = LoadSlopes::new(&regressor, &groups).at(&solved, (&engine, &data)).unwrap();
        for (column, group) in groups.iter().enumerate() {
            let k = group[0];
            let step = 1e-4 * parameters[k].scale.min(1.0);
            let changed = |by: f64| {
                let mut changed = values.clone();
                changed[k] += by;
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
                    parameters[k].name,
                );
            }
        }
    }
    assert!(tried >= 4, "{tried}");
}
