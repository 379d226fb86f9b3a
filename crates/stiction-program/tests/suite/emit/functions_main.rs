//! Kinematics, reactions and holding efforts against numbers of the solver.

mod five_bar;

use five_bar::{ACTUATORS, BODIES, COORDINATES, Code, JOINTS, Math, Params, Real, State};

STD_MATH
static ALL: [[f64; WIDTH]; ROWS] = [
DATA];

fn compare(what: &str, found: &[f64], expected: &[f64]) {
    let most = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= 1e-10 * most, "{what}: {a} {b}");
    }
    assert_eq!(found.len(), expected.len());
}

fn main() {
    let params = Params::default();
    for row in &ALL {
        let number = |first: usize| -> [f64; COORDINATES] {
            row[first..first + COORDINATES].try_into().unwrap()
        };
        let (q, qd, qdd) = (number(0), number(COORDINATES), number(2 * COORDINATES));
        let mut state = State::new::<Std>(&q).unwrap();
        let mut tau = [0.0; ACTUATORS];
        let (code, _, reactions) = state.reactions::<Std>(&params, &q, &qd, &qdd, &mut tau);
        assert_eq!(code, Code::Done);
        let mut hold = [0.0; ACTUATORS];
        assert_eq!(state.hold::<Std>(&params, &q, None, &mut hold).0, Code::Done);
        let (poses, twists) = (state.poses::<Std>(&q).unwrap(), state.twists::<Std>(&q, &qd).unwrap());
        let expected = &row[3 * COORDINATES..];
        let (a, expected) = expected.split_at(ACTUATORS);
        compare("efforts", &tau, a);
        let (a, expected) = expected.split_at(6 * JOINTS);
        compare("reactions", &reactions.unwrap().concat(), a);
        let (a, expected) = expected.split_at(ACTUATORS);
        compare("hold", &hold, a);
        let (a, expected) = expected.split_at(12 * BODIES);
        compare("poses", &poses.concat(), a);
        compare("twists", &twists.concat(), expected);
        for body in 0..BODIES {
            let jacobian = state.jacobian::<Std>(&q, body).unwrap();
            for k in 0..6 {
                let sum: f64 = jacobian[k].iter().zip(&qd).map(|(a, b)| a * b).sum();
                assert!((sum - twists[body][k]).abs() < 1e-10, "{sum} {}", twists[body][k]);
            }
        }
        assert_eq!(state.jacobian::<Std>(&q, BODIES), Err(Code::BadInput));
    }
}
