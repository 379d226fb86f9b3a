
/* Computes the poses of all bodies; the loops must be closed. */
static void find_poses(real *w, real *r)
{
@POSES@}

/* Computes the twists of all bodies; the loops must be closed. */
static void find_twists(real *w, real *r)
{
@TWISTS@}

/* Closes the loops at q; returns a code. */
static int close_at(@NAME@_state *warm, const real *q)
{
    real tree[TREE];
    real residual = 0;
    int corrections = 0;
    int k;
    if (warm == 0 || q == 0 || !are_finite(q, COORDINATES)) {
        return @GUARD@_BAD_INPUT;
    }
    if (warm->ready != READY) {
        return @GUARD@_NOT_READY;
    }
    for (k = 0; k < TREE; ++k) {
        tree[k] = warm->tree[k];
    }
    if (!close_loops(tree, q, &residual, &corrections)) {
        return @GUARD@_OPEN;
    }
    for (k = 0; k < TREE; ++k) {
        warm->tree[k] = tree[k];
    }
    return @GUARD@_OK;
}

int @NAME@_poses(@NAME@_state *warm, const real q[COORDINATES], real poses[12 * @GUARD@_BODIES])
{
    real w[@POSE_WORK@];
    real r[12 * @GUARD@_BODIES + 1];
    int k;
    const int code = poses == 0 ? @GUARD@_BAD_INPUT : close_at(warm, q);
    if (code != @GUARD@_OK) {
        return code;
    }
    for (k = 0; k < TREE; ++k) {
        w[k] = warm->tree[k];
    }
    for (k = 0; k < COORDINATES; ++k) {
        w[TREE + 2 * k] = q[k];
        w[TREE + 2 * k + 1] = 0;
    }
    find_poses(w, r);
    if (!(r[12 * @GUARD@_BODIES] > 0) || !are_finite(r, 12 * @GUARD@_BODIES)) {
        return @GUARD@_SINGULAR;
    }
    for (k = 0; k < 12 * @GUARD@_BODIES; ++k) {
        poses[k] = r[k];
    }
    return code;
}

/* Twists at closed loops; returns a code. */
static int twists_at(const @NAME@_state *warm, const real *q, const real *qd, real *r)
{
    real w[@TWIST_WORK@];
    int k;
    for (k = 0; k < TREE; ++k) {
        w[k] = warm->tree[k];
    }
    for (k = 0; k < COORDINATES; ++k) {
        w[TREE + 2 * k] = q[k];
        w[TREE + 2 * k + 1] = qd[k];
    }
    find_twists(w, r);
    if (!(r[6 * @GUARD@_BODIES] > 0) || !are_finite(r, 6 * @GUARD@_BODIES)) {
        return @GUARD@_SINGULAR;
    }
    return @GUARD@_OK;
}

int @NAME@_twists(@NAME@_state *warm, const real q[COORDINATES], const real qd[COORDINATES],
    real twists[6 * @GUARD@_BODIES])
{
    real r[6 * @GUARD@_BODIES + 1];
    int k;
    int code = @GUARD@_BAD_INPUT;
    if (twists != 0 && qd != 0 && are_finite(qd, COORDINATES)) {
        code = close_at(warm, q);
    }
    if (code == @GUARD@_OK) {
        code = twists_at(warm, q, qd, r);
    }
    for (k = 0; k < 6 * @GUARD@_BODIES && code == @GUARD@_OK; ++k) {
        twists[k] = r[k];
    }
    return code;
}

int @NAME@_jacobian(@NAME@_state *warm, const real q[COORDINATES], int body,
    real jacobian[6 * COORDINATES])
{
    real r[6 * @GUARD@_BODIES + 1];
    real found[6 * COORDINATES];
    real qd[COORDINATES];
    int row;
    int column;
    int k;
    int code = @GUARD@_BAD_INPUT;
    if (jacobian != 0 && body >= 0 && body < @GUARD@_BODIES) {
        code = close_at(warm, q);
    }
    for (column = 0; column < COORDINATES && code == @GUARD@_OK; ++column) {
        for (k = 0; k < COORDINATES; ++k) {
            qd[k] = k == column ? 1 : 0;
        }
        code = twists_at(warm, q, qd, r);
        for (row = 0; row < 6; ++row) {
            found[row * COORDINATES + column] = r[6 * body + row];
        }
    }
    for (k = 0; k < 6 * COORDINATES && code == @GUARD@_OK; ++k) {
        jacobian[k] = found[k];
    }
    return code;
}
