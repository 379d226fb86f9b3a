//! Programs do not allocate memory while they run, compiled or interpreted, for one state or
//! several lanes.

use crate::common::Robot;
use crate::counting::allocations;
use std::hint::black_box;
use stiction_program::InverseProgram;

#[test]
fn programs_allocate_nothing() {
    assert_eq!(allocations(|| drop(black_box(Box::new(1)))), 1, "the counter counts");
    for name in ["3rps", "gough", "3upu"] {
        let Robot { solver, signal, loads } = Robot::new(name, None);
        for machine in [true, false] {
            let program = InverseProgram::record_with(&solver, &signal, &loads, machine).unwrap();
            for lanes in [1, program.lanes()] {
                let mut memory = program.memory(lanes);
                let mut settled = vec![false; lanes];
                let state = solver.state();
                let run = || {
                    for lane in 0..lanes {
                        program.set(&mut memory, lane, state, &signal[0], &loads);
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
