//! Self-test: reproduces the test vectors, which come from the general solver of stiction, not from
//! this code.

#[path = "@NAME@.rs"]
mod code;

use code::{ACTUATORS, COORDINATES, Code, Math, Params, Real, State};

/// Largest permitted difference of an effort, relative to the largest effort of the test vector.
const TOLERANCE: f64 = @TOLERANCE@;
/// Factor by which the difference may be larger in one row of a hundred. The pivots are those of the home position; in
/// single precision, they magnify rounding errors near some other positions. In double precision, the factor is 1.
const MAGNIFIED: f64 = @MAGNIFIED@;

@STD_MATH@
fn main() {
    let path = std::env::args().nth(1).unwrap_or_else(|| "vectors.csv".into());
    let text = std::fs::read_to_string(&path).expect("the file of test vectors");
    let (mut rows, mut failures, mut magnified, mut worst) = (0, 0, 0, 0.0_f64);
    for line in text.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
        let part = |k: usize| -> [Real; COORDINATES] {
            core::array::from_fn(|i| numbers[k * COORDINATES + i] as Real)
        };
        let expected = &numbers[3 * COORDINATES..];
        let (q, qd, qdd) = (part(0), part(1), part(2));
        let mut tau = [0.0; ACTUATORS];
        rows += 1;
        let params = Params::default();
        let mut state = match State::new::<Std>(&q) {
            Ok(state) => state,
            Err(code) => {
                println!("row {rows}: {code:?}");
                failures += 1;
                continue;
            }
        };
        let (code, _) = state.ff::<Std>(&params, &q, &qd, &qdd, None, &mut tau);
        let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let apart = tau.iter().zip(expected).map(|(a, b)| (f64::from(*a) - b).abs());
        let difference = apart.fold(0.0, f64::max) / scale;
        worst = worst.max(difference);
        if code != Code::Done || !(difference <= TOLERANCE) {
            println!("row {rows}: {code:?}, relative difference {difference:e}");
            if code == Code::Done && difference <= MAGNIFIED * TOLERANCE {
                magnified += 1;
            } else {
                failures += 1;
            }
        }
        // NaN must be refused, and the last efforts must remain.
        let last = tau;
        let (code, _) = state.ff::<Std>(&params, &q, &[Real::NAN; COORDINATES], &qdd, None, &mut tau);
        if code != Code::BadInput || tau != last {
            println!("row {rows}: NaN is not refused");
            failures += 1;
        }
    }
    if magnified > 1 + rows / 100 {
        failures += magnified;
    }
    println!("@NAME@: {rows} test vectors, {failures} failures, largest relative difference {worst:.1e}");
    if failures > 0 || rows == 0 {
        std::process::exit(1);
    }
}
