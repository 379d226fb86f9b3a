//! Absence of allocations in the kernels after set-up, along the whole motions of the gallery's
//! robots.

use crate::common::*;
use crate::counting::allocations;
use stiction_core::dynamics::{InverseDynamics, Settings};

#[test]
fn kernels_allocate_nothing() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 1, "the counter counts");
    for name in regular() {
        for friction in MODES {
            let model = model(name);
            let job = default_job(&model, friction);
            let coordinates: Vec<_> = job.motion.coordinates.iter().map(|(c, _)| *c).collect();
            let start = job.motion.start;
            let targets: Vec<_> = job.motion.at(start).collect();
            let settings = Settings { friction, ..Settings::default() };
            let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
            let solver =
                InverseDynamics::new(mechanism, initial_poses, &coordinates, &targets, settings)
                    .unwrap();
            let compiled = solver.model().unwrap();
            let parameters = solver.parameters().clone();
            let mut data = compiled.data(solver.state(), settings);
            for k in 0..=1000 {
                let time = start + job.motion.duration * f64::from(k) / 1000.0;
                let targets: Vec<_> = job.motion.at(time).collect();
                let loads: Vec<_> = job.load.at(time).collect();
                let run = || {
                    compiled.evaluate(&parameters, &mut data, &targets, &loads);
                };
                assert_eq!(allocations(run), 0, "{name} {friction:?} at {time}");
            }
        }
    }
}
