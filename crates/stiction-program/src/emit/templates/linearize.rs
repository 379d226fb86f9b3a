
/// Number of joints with friction.
const RUBBING_JOINTS: usize = @RUBBING_JOINTS@;
/// Number of values in the workspace of the derivatives.
const SLOPE_WORK: usize = @SLOPE_WORK@;
/// Index of the first reaction of a joint with friction in the workspace of the derivatives.
const FIRST_REACTION: usize = FIRST_TARGET + 3 * COORDINATES;
/// Index of the first component of the direction in the workspace of the derivatives.
const FIRST_SLOPE: usize = FIRST_REACTION + 6 * RUBBING_JOINTS;

/// Computes the part of the derivatives that does not depend on the direction. The result `r[0]` is
/// positive if the derivatives exist.
fn prepare_slopes<M: Math>(w: &mut [Real; SLOPE_WORK], r: &mut [Real; 1]) {
@SLOPE_PREPARATION@}

/// Computes the derivatives of the efforts along the direction that is stored in `w`.
fn find_slopes<M: Math>(w: &mut [Real; SLOPE_WORK], r: &mut [Real; ACTUATORS]) {
@SLOPES@}

/// Matrix with a row for each actuator and a column for each coordinate.
pub type Matrix = [[Real; COORDINATES]; ACTUATORS];

/// Workspace for the derivatives of the efforts at one state, which are computed along one
/// direction after another.
struct Linear {
    w: [Real; SLOPE_WORK],
}

impl Linear {
    /// Prepares the derivatives at a state with closed loops; `found` are the results of inverse
    /// dynamics at this state. Returns `None` if the derivatives do not exist.
    fn new<M: Math>(
        params: &Params,
        tree: &[Real; TREE],
        (q, qd, qdd): (&[Real; COORDINATES], &[Real; COORDINATES], &[Real; COORDINATES]),
        found: &[Real; ANSWERS],
    ) -> Option<Self> {
        const RUBBING: [usize; RUBBING_JOINTS + 1] = [@RUBBING@];
        let mut own = Self { w: [0.0; SLOPE_WORK] };
        let mut r = [0.0];
        set_parameters(&mut own.w, params);
        set_motion(&mut own.w, tree, q, qd, qdd);
        for joint in 0..RUBBING_JOINTS {
            let (to, from) = (FIRST_REACTION + 6 * joint, ACTUATORS + 6 * RUBBING[joint]);
            own.w[to..to + 6].copy_from_slice(&found[from..from + 6]);
        }
        prepare_slopes::<M>(&mut own.w, &mut r);
        if r[0] > 0.0 { Some(own) } else { None }
    }

    /// Computes the derivatives of the efforts with respect to one kind of input: 0 positions, 1
    /// rates, 2 accelerations. Returns `None` if a derivative is not finite.
    fn by<M: Math>(&mut self, kind: usize) -> Option<Matrix> {
        let mut matrix = [[0.0; COORDINATES]; ACTUATORS];
        for column in 0..COORDINATES {
            let place = FIRST_SLOPE + kind * COORDINATES + column;
            let mut r = [0.0; ACTUATORS];
            self.w[place] = 1.0;
            find_slopes::<M>(&mut self.w, &mut r);
            self.w[place] = 0.0;
            for row in 0..ACTUATORS {
                matrix[row][column] = r[row];
            }
        }
        if matrix.iter().all(|row| are_finite(row)) { Some(matrix) } else { None }
    }
}
