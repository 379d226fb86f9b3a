//! States of motion at which the meaning of nodes is compared.

use stiction::dynamics::{AppliedLoad, InverseDynamics};
use stiction::kinematics::Target;
use stiction::random::Random;

/// How many samples there are: branches are told apart by their patterns over all of them.
const SAMPLES: usize = 40;
/// Positions among them: each takes time to assemble.
const POSITIONS: usize = 10;

/// Generic states along a course: positions near those given, with any rates, accelerations and loads.
/// Each is a row of the program's inputs. None if the course cannot be followed.
pub(crate) fn samples(
    solver: &InverseDynamics,
    course: &[Vec<Target<f64>>],
    loads: &[AppliedLoad<f64>],
) -> Option<Vec<Vec<f64>>> {
    let mut random = Random::new(1);
    let mut solver = solver.clone();
    let length = solver.mechanism().characteristic_length();
    if course.is_empty() {
        return None;
    }
    let mut samples = Vec::with_capacity(SAMPLES);
    for k in 0..SAMPLES {
        let mut targets = course.get(k % POSITIONS.min(course.len()))?.clone();
        for target in &mut targets {
            // Off the course, which may be special, by little.
            target.value += 0.01 * length.min(1.0) * random.number();
            target.rate = random.number();
            target.acceleration = 10.0 * random.number();
        }
        solver.move_to(&targets).ok()?;
        let state = solver.assembly().state();
        let mut sample = state.coordinates.clone();
        sample.extend(&state.rates);
        sample.extend(&state.accelerations);
        sample.extend(targets.iter().flat_map(|t| [t.value, t.rate, t.acceleration]));
        sample.extend((0..6 * loads.len()).map(|_| 100.0 * random.number()));
        samples.push(sample);
    }
    Some(samples)
}
