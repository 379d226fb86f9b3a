
/* Joints with friction, and the places of their reactions and of the direction in the workspace of
   the derivatives. */
#define RUBBING_JOINTS @RUBBING_JOINTS@
#define SLOPE_WORK @SLOPE_WORK@
#define FIRST_REACTION (FIRST_TARGET + 3 * COORDINATES)
#define FIRST_SLOPE (FIRST_REACTION + 6 * RUBBING_JOINTS)

/* Part of the derivatives that does not depend on the direction; r[0] is positive if they exist. */
static void prepare_slopes(real *w, real *r)
{
@SLOPE_PREPARATION@}

/* Slopes of the efforts along the direction in w. */
static void find_slopes(const real *w, real *r)
{
@SLOPES@}

/* Prepares derivatives after a call of `answer` with its results; returns 0 if there are none. */
static int linearize(const @NAME@_params *params, const @NAME@_state *warm, const real *q,
    const real *qd, const real *qdd, const real *found, real *w)
{
    static const int RUBBING[RUBBING_JOINTS + 1] = { @RUBBING@ };
    real r[1];
    int joint;
    int k;
    set_parameters(w, params);
    set_motion(w, warm->tree, q, qd, qdd);
    for (joint = 0; joint < RUBBING_JOINTS; ++joint) {
        for (k = 0; k < 6; ++k) {
            w[FIRST_REACTION + 6 * joint + k] = found[DRIVES + 6 * RUBBING[joint] + k];
        }
    }
    for (k = 0; k < 3 * COORDINATES; ++k) {
        w[FIRST_SLOPE + k] = 0;
    }
    prepare_slopes(w, r);
    return r[0] > 0;
}

/* Derivatives of the efforts with respect to one kind of input (0 positions, 1 rates, 2 accelerations), row by row. */
static int differentiate(real *w, int kind, real *matrix)
{
    int row;
    int column;
    for (column = 0; column < COORDINATES; ++column) {
        real r[DRIVES];
        w[FIRST_SLOPE + kind * COORDINATES + column] = 1;
        find_slopes(w, r);
        w[FIRST_SLOPE + kind * COORDINATES + column] = 0;
        for (row = 0; row < DRIVES; ++row) {
            matrix[row * COORDINATES + column] = r[row];
        }
    }
    return are_finite(matrix, DRIVES * COORDINATES);
}
