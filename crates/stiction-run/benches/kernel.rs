//! Time per sample: motion and all forces of robots of the gallery, compared with a dense solution.
//!
//! The dense solution is one factorization of the 6n x 6n Newton-Euler system of the same robot at
//! the same position (nalgebra's LU, with given matrix and right-hand side). A program that sets up
//! the equations and passes them to a library has this cost for each sample and each friction
//! iteration.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::Target;
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Lanes;
use stiction_format::{ModelFile, Source, gallery, read};

const LANES: usize = 8;
type L = Lanes<f64, LANES>;

fn model(name: &str) -> ModelFile {
    let text = gallery::get(name).expect("it is in the gallery");
    read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into()))
        .expect("it is accepted")
}

/// Creates a robot at an instant of its default motion.
fn robot(name: &str) -> (InverseDynamics, Vec<Target<f64>>, Vec<AppliedLoad<f64>>) {
    let model = model(name);
    let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
    let load = model.load(model.default_load.as_deref().unwrap()).unwrap();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let time = 0.3 * motion.duration;
    let (start, targets): (Vec<_>, Vec<_>) = (motion.at(0.0).collect(), motion.at(time).collect());
    let mut solver = InverseDynamics::new(
        model.mechanism.clone(),
        &model.initial_poses,
        &coordinates,
        &start,
        Settings::default(),
    )
    .unwrap();
    let follow = |t: f64, targets: &mut [Target<f64>]| {
        targets.iter_mut().zip(motion.at(t)).for_each(|(target, at)| *target = at);
    };
    solver.follow(0.0, time, follow).unwrap();
    (solver, targets, load.at(time).collect())
}

fn samples(c: &mut Criterion) {
    for name in ["3rps", "zhang2018-regular", "gough", "slider-crank"] {
        let (solver, targets, loads) = robot(name);
        let compiled = solver.model().unwrap();
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(1));
        for (what, friction) in
            [("frictionless", FrictionMode::Off), ("with friction", FrictionMode::Converged)]
        {
            let settings = Settings { friction, ..Settings::default() };
            let parameters = solver.parameters().clone();
            let mut data = compiled.data(solver.state(), settings);
            group.bench_function(BenchmarkId::new("kernel", what), |b| {
                b.iter(|| {
                    let targets = black_box(&targets);
                    compiled.evaluate(&parameters, &mut data, targets, &loads);
                    data.inverse.efforts()[0]
                });
            });
        }

        // The largest square part of the dense system contains all rows, all reactions and actuator
        // forces.
        let statics = solver.statics();
        let matrix = statics.scaled_matrix().to_dense();
        if matrix.nrows() == matrix.ncols() {
            let right = nalgebra::DVector::from_fn(matrix.nrows(), |row, _| row as f64);
            group.bench_function(BenchmarkId::new("dense LU", matrix.nrows()), |b| {
                b.iter(|| black_box(&matrix).clone().lu().solve(&right).map(|x| x[0]));
            });
        }

        group.throughput(Throughput::Elements(LANES as u64));
        let parameters = Parameters::<L>::new(solver.mechanism());
        let settings = Settings { friction: FrictionMode::Converged, ..Settings::default() };
        let mut data = compiled.data(solver.state(), settings);
        let targets: Vec<Target<L>> = targets.iter().map(|target| target.lift()).collect();
        let loads: Vec<AppliedLoad<L>> = loads.iter().map(|load| load.lift()).collect();
        group.bench_function(BenchmarkId::new("kernel, eight lanes", "with friction"), |b| {
            b.iter(|| {
                let targets = black_box(&targets);
                compiled.evaluate(&parameters, &mut data, targets, &loads);
                data.inverse.efforts()[0]
            });
        });
        group.finish();
    }
}

criterion_group!(benches, samples);
criterion_main!(benches);
