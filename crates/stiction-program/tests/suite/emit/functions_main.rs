//! Compares kinematics, reactions, holding efforts, loads and forward dynamics with results of the
//! solver, and derivatives with differences of efforts.

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
        let (code, _, found) = state.derivatives::<Std>(&params, &q, &qd, &qdd, &mut [0.0; ACTUATORS]);
        assert_eq!(code, Code::Done);
        let size = 1e3 * a.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (kind, matrix) in found.unwrap().iter().enumerate() {
            for column in 0..COORDINATES {
                let mut sides = [[0.0; ACTUATORS]; 2];
                for (side, tau) in sides.iter_mut().enumerate() {
                    let mut moved = [q, qd, qdd];
                    moved[kind][column] += if side == 0 { -1e-6 } else { 1e-6 };
                    let [q, qd, qdd] = &moved;
                    assert_eq!(state.ff::<Std>(&params, q, qd, qdd, None, tau).0, Code::Done);
                }
                for row in 0..ACTUATORS {
                    let slope = (sides[1][row] - sides[0][row]) / 2e-6;
                    assert!((matrix[row][column] - slope).abs() < 1e-10 * size, "{slope} {kind}");
                }
            }
        }
        let efforts: [f64; ACTUATORS] = a.try_into().unwrap();
        let found = state.accelerations::<Std>(&params, &q, &qd, &efforts).unwrap();
        assert!(found.iter().zip(&qdd).all(|(a, b)| (a - b).abs() < 1e-7), "{found:?} {qdd:?}");
        let still = state.accelerations::<Std>(&params, &q, &[0.0; COORDINATES], &efforts);
        assert_eq!(still, Err(Code::Undetermined));
        let (a, expected) = expected.split_at(ACTUATORS);
        let loaded = Params { wrench: WRENCH, ..Params::default() };
        assert_eq!(state.ff::<Std>(&loaded, &q, &qd, &qdd, None, &mut tau).0, Code::Done);
        compare("efforts under a load", &tau, a);
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
