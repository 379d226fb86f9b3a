//! Compares the singularity index of the code in Rust with that of the code in C, at the same states.

mod NAME;

use NAME::{ACTUATORS, COORDINATES, Code, Math, Params, Real, State};

STD_MATH
fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect()
}

fn main() {
    let states = numbers(include_bytes!("../FOLDER/states.bin"));
    let answers = numbers(include_bytes!("../FOLDER/answers.bin"));
    let params = Params::default();
    let mut compared = 0;
    let rows = states.chunks_exact(3 * COORDINATES);
    assert_eq!(rows.len(), answers.len() / (4 + ACTUATORS));
    for (row, answer) in rows.zip(answers.chunks_exact(4 + ACTUATORS)) {
        let part = |k: usize| -> [Real; COORDINATES] {
            core::array::from_fn(|i| row[k * COORDINATES + i] as Real)
        };
        let (q, v, a) = (part(0), part(1), part(2));
        let Ok(mut state) = State::new::<Std>(&q) else {
            assert!(answer[0] < 0.0, "{answer:?}");
            continue;
        };
        let mut tau = [0.0; ACTUATORS];
        let (code, info) = state.ff::<Std>(&params, &q, &v, &a, None, &mut tau);
        assert_eq!(code == Code::Done, answer[0] == 0.0, "{code:?}, {answer:?}");
        let index = f64::from(info.singularity_index);
        assert!(index.is_finite() && (1..=40).contains(&info.index_passes), "{info:?}");
        if code == Code::Done {
            assert!((index - answer[3]).abs() <= LIMIT * index, "{index}, {answer:?}");
            compared += 1;
        }
        // Without the index, the efforts are the same.
        let params = Params { wants_index: false, ..params.clone() };
        let mut others = [0.0; ACTUATORS];
        let mut state = State::new::<Std>(&q).unwrap();
        assert_eq!(state.ff::<Std>(&params, &q, &v, &a, None, &mut others).0, code);
        assert_eq!(others, tau);
    }
    assert!(2 * compared > answers.len() / (4 + ACTUATORS), "{compared}");
}
