//! Verification of recorded programs of forward dynamics.
//!
//! Value numbering distinguishes nodes by their values and bounds of rounding errors. It may merge
//! different nodes if these bounds are large and the difference of the values is small. Every
//! program is therefore verified: the general kernel of `stiction-core`, evaluated with the
//! accelerations and friction forces that the program computes, must reproduce the program's
//! efforts, reactions and normal loads.

use crate::forward::ForwardProgram;
use crate::motions::run;
use crate::recording::RecordingSource;
use crate::samples::Sample;
use stiction_core::kinematics::Target;
use stiction_core::random::Random;

/// Largest relative difference that is attributed to rounding. Four kinds of values are compared:
/// normal loads and friction forces, efforts, reaction forces, and reaction moments. Each
/// difference is relative to the largest value of its kind.
const ROUNDING: f64 = 1e-11;

impl RecordingSource<'_> {
    /// Compares the results of the program with those of the general kernel, at all samples at
    /// which the program's assumptions hold. Returns `false` if any results differ, or if at no
    /// sample the assumptions hold and the normal loads converge, with friction or without.
    pub(crate) fn confirms(&self, program: &ForwardProgram, samples: &[Sample]) -> bool {
        let parameters = self.solver.parameters();
        let like = self.solver.state();
        let [count, _, joints, interfaces] = program.sizes();
        let mut memory = program.memory(1);
        let mut holds = [false];
        let mut random = Random::new(4);
        let mut confirmed = [0; 2];
        for sample in samples {
            let Sample { state, targets, loads, .. } = sample;
            // Efforts close to those of inverse dynamics at this state, so that friction does not
            // lock the actuators.
            let coordinates = &state.coordinates;
            let ran = run(self.model, parameters, like, coordinates, (targets, loads), 0);
            let scale = ran.inverse.efforts().iter().fold(1e-9_f64, |max, x| max.max(x.abs()));
            let efforts: Vec<f64> = ran
                .inverse
                .efforts()
                .iter()
                .map(|drive| drive + 0.1 * scale * random.number())
                .collect();
            program.set(&mut memory, 0, state, loads, &efforts);
            for friction in [false, true] {
                if friction {
                    program.run(&mut memory, &mut holds);
                } else {
                    program.run_frictionless(&mut memory, &mut holds);
                }
                // The program is invalid here: a condition may have a sign that did not occur in
                // the samples of the recording.
                if !holds[0] {
                    continue;
                }
                let moving: Vec<Target<f64>> = (0..count)
                    .map(|k| Target {
                        acceleration: match friction {
                            true => program.acceleration(&memory, 0, k),
                            false => program.ideal_acceleration(&memory, 0, k),
                        },
                        ..targets[k]
                    })
                    .collect();
                let mut again = run(self.model, parameters, like, coordinates, (&moving, loads), 0);
                let bodies = &again.kinematics.bodies;
                let states = again.inverse.interfaces().to_vec();
                let mut kinds: [Vec<(f64, f64)>; 4] = Default::default();
                if friction {
                    let of = |k| program.interface(&memory, 0, k);
                    let frictions: Vec<f64> = (0..interfaces).map(|k| of(k)[2]).collect();
                    again.inverse.solve_with(self.model, parameters, bodies, &frictions);
                    for (k, (interface, state)) in
                        parameters.interfaces.iter().zip(states).enumerate()
                    {
                        let joint = interface.joint;
                        let (j, l) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
                        let wrench = again.inverse.joint_wrenches()[joint];
                        let pitch = parameters.pitch[joint];
                        let load = state.load_in(interface, pitch, j, l, wrench).value;
                        let (coefficient, constant) = state.resistance();
                        kinds[0].push((of(k)[0], load));
                        kinds[0].push((of(k)[2], coefficient * load + constant));
                    }
                }
                kinds[1]
                    .extend(efforts.iter().copied().zip(again.inverse.efforts().iter().copied()));
                for joint in 0..joints {
                    let (force, moment) = again.inverse.reaction(bodies, joint);
                    let found = match friction {
                        true => program.reaction(&memory, 0, joint),
                        false => program.ideal_reaction(&memory, 0, joint),
                    };
                    kinds[2].extend(found.into_iter().zip(force.to_array()));
                    kinds[3].extend(found.into_iter().skip(3).zip(moment.to_array()));
                }
                let agree = |pairs: &Vec<(f64, f64)>| {
                    let sizes = pairs.iter().map(|(a, b)| a.abs().max(b.abs()));
                    let largest = sizes.fold(f64::MIN_POSITIVE, f64::max);
                    pairs.iter().all(|(a, b)| (a - b).abs() <= ROUNDING * largest)
                };
                if !kinds.iter().all(agree) {
                    return false;
                }
                confirmed[usize::from(friction)] += 1;
            }
        }
        !confirmed.contains(&0)
    }
}
