
/// The iteration ends when a step changes the accelerations by at most this fraction.
const SETTLED_STEP: Real = @SETTLED_STEP@;
/// The iteration also ends when the efforts of the accelerations differ from the given efforts by
/// at most this fraction.
const RESIDUAL: Real = @RESIDUAL@;
/// Largest relative error that is expected of the efforts and of their derivatives.
const INEXACT: Real = @TOLERANCE@;

/// Solves `a y = x` by Gaussian elimination with pivoting, and returns `y`. Rows and columns, whose
/// units differ, are first divided by their largest entries. Returns `None` if a pivot does not
/// exceed the error of the matrix, because no digit of the result would be correct.
fn eliminate(mut a: Matrix, mut x: [Real; COORDINATES]) -> Option<[Real; COORDINATES]> {
    for row in 0..COORDINATES {
        let size = largest(&a[row]);
        if !(size > 0.0) {
            return None;
        }
        for k in 0..COORDINATES {
            a[row][k] /= size;
        }
        x[row] /= size;
    }
    let mut units = [0.0; COORDINATES];
    for column in 0..COORDINATES {
        for row in 0..COORDINATES {
            let size = size_of(a[row][column]);
            if size > units[column] {
                units[column] = size;
            }
        }
        if !(units[column] > 0.0) {
            return None;
        }
        for row in 0..COORDINATES {
            a[row][column] /= units[column];
        }
    }
    for column in 0..COORDINATES {
        let mut best = column;
        for row in column + 1..COORDINATES {
            if size_of(a[row][column]) > size_of(a[best][column]) {
                best = row;
            }
        }
        if !(size_of(a[best][column]) > INEXACT) {
            return None;
        }
        a.swap(column, best);
        x.swap(column, best);
        for row in column + 1..COORDINATES {
            let factor = a[row][column] / a[column][column];
            for k in column..COORDINATES {
                a[row][k] -= factor * a[column][k];
            }
            x[row] -= factor * x[column];
        }
    }
    for column in (0..COORDINATES).rev() {
        x[column] /= a[column][column];
        for row in 0..column {
            x[row] -= a[row][column] * x[column];
        }
    }
    for column in 0..COORDINATES {
        x[column] /= units[column];
    }
    if are_finite(&x) { Some(x) } else { None }
}

impl State {
    /// Forward dynamics: computes the accelerations that the efforts `tau` cause at positions `q`
    /// and rates `qd`, with friction, in at most @STEPS@ Newton steps.
    ///
    /// # Errors
    /// [`Code::BadInput`] if an input is not finite. [`Code::Open`] if the loops cannot be closed.
    /// [`Code::Undetermined`] if joints are at rest: this function does not decide whether they
    /// stick or begin to slide. [`Code::Frictionless`] where friction has no solution, or the steps
    /// do not converge. [`Code::Singular`] where efforts do not determine the accelerations.
    pub fn accelerations<M: Math>(
        &mut self,
        params: &Params,
        q: &[Real; COORDINATES],
        qd: &[Real; COORDINATES],
        tau: &[Real; ACTUATORS],
    ) -> Result<[Real; COORDINATES], Code> {
        if !are_finite(tau) {
            return Err(Code::BadInput);
        }
        // The computation uses a copy of the state, so that the stored direction of motion does not
        // change.
        let mut copy = self.clone();
        let params = &Params { wants_index: false, ..params.clone() };
        let mut now = [0.0; COORDINATES];
        for _ in 0..MOST_STEPS {
            let mut needed = [0.0; ACTUATORS];
            let (code, _, found) = copy.answer::<M>(params, q, (qd, &now, None), &mut needed);
            if code != Code::Done {
                return Err(code);
            }
            let mut left = [0.0; COORDINATES];
            for k in 0..ACTUATORS {
                left[k] = tau[k] - needed[k];
            }
            let settled = largest(&left) <= RESIDUAL * (largest(tau) + largest(&needed));
            let matrix = Linear::new::<M>(params, &copy.tree, (q, qd, &now), &found)
                .and_then(|mut linear| linear.by::<M>(2))
                .ok_or(Code::Undetermined)?;
            let change = eliminate(matrix, left).ok_or(Code::Singular)?;
            for k in 0..COORDINATES {
                now[k] += change[k];
            }
            // Newton steps square the error.
            if settled || largest(&change) <= SETTLED_STEP * largest(&now) {
                self.tree = copy.tree;
                return Ok(now);
            }
        }
        Err(Code::Frictionless)
    }
}
