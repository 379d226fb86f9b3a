//! Programs allocate nothing while they run, compiled or interpreted, alone or in lanes.

#[path = "../../stiction/tests/common/counting.rs"]
mod counting;

use counting::allocations;
use std::hint::black_box;
use stiction::dynamics::{InverseDynamics, Settings};
use stiction_model::{Source, gallery, read};
use stiction_program::InverseProgram;

#[test]
fn programs_allocate_nothing() {
    assert_eq!(allocations(|| drop(black_box(Box::new(1)))), 1, "the counter counts");
    for name in ["3rps", "gough", "3upu"] {
        let text = gallery::get(name).unwrap();
        let model = read(&Source::new(name, text), &|_| Err("no files".into())).unwrap();
        let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
        let load = model.load(model.default_load.as_deref().unwrap()).unwrap();
        let loads: Vec<_> = load.at(0.1).collect();
        let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let course: Vec<Vec<_>> = (0..10)
            .map(|k| motion.at(0.1 * (f64::from(k) + 0.37) * motion.duration).collect())
            .collect();
        let (mechanism, homes) = (model.mechanism.clone(), &model.homes);
        let settings = Settings::default();
        let solver =
            InverseDynamics::new(mechanism, homes, &coordinates, &course[0], settings).unwrap();
        for machine in [true, false] {
            let program = InverseProgram::record_with(&solver, &course, &loads, machine).unwrap();
            for lanes in [1, program.lanes()] {
                let mut memory = program.memory(lanes);
                let mut settled = vec![false; lanes];
                let state = solver.assembly().state();
                let run = || {
                    for lane in 0..lanes {
                        program.set(&mut memory, lane, state, &course[0], &loads);
                    }
                    program.run_frictionless(&mut memory, &mut settled);
                    program.run(&mut memory, &mut settled);
                    black_box(program.drive(&memory, 0, 0));
                };
                assert_eq!(allocations(run), 0, "{name}, {lanes} lanes, machine {machine}");
                assert!(settled.iter().all(|settled| *settled), "{name}");
            }
        }
    }
}
