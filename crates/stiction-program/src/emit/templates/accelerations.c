
/* Relative changes of the accelerations and of the efforts at which iterations end. */
static const real SETTLED_STEP = @SETTLED_STEP@;
static const real RESIDUAL = @RESIDUAL@;
/* Relative error of the efforts and of their derivatives. */
static const real INEXACT = @TOLERANCE@@F@;

/* Solves a x = x by elimination with pivoting. Rows and columns, whose units differ, are first divided by their
   largest entries. Returns 0 if a pivot is not above the error of the matrix: no digit of x would be correct. */
static int eliminate(real *a, real *x)
{
    real units[COORDINATES];
    int column;
    for (column = 0; column < COORDINATES; ++column) {
        real *row = a + column * COORDINATES;
        const real size = largest(row, COORDINATES);
        int k;
        if (!(size > 0)) {
            return 0;
        }
        for (k = 0; k < COORDINATES; ++k) {
            row[k] /= size;
        }
        x[column] /= size;
    }
    for (column = 0; column < COORDINATES; ++column) {
        int row;
        units[column] = 0;
        for (row = 0; row < COORDINATES; ++row) {
            const real size = fabs@F@(a[row * COORDINATES + column]);
            units[column] = size > units[column] ? size : units[column];
        }
        if (!(units[column] > 0)) {
            return 0;
        }
        for (row = 0; row < COORDINATES; ++row) {
            a[row * COORDINATES + column] /= units[column];
        }
    }
    for (column = 0; column < COORDINATES; ++column) {
        int best = column;
        int row;
        int k;
        for (row = column + 1; row < COORDINATES; ++row) {
            const real size = fabs@F@(a[row * COORDINATES + column]);
            best = size > fabs@F@(a[best * COORDINATES + column]) ? row : best;
        }
        if (!(fabs@F@(a[best * COORDINATES + column]) > INEXACT)) {
            return 0;
        }
        for (k = 0; k < COORDINATES; ++k) {
            const real entry = a[column * COORDINATES + k];
            a[column * COORDINATES + k] = a[best * COORDINATES + k];
            a[best * COORDINATES + k] = entry;
        }
        if (best != column) {
            const real entry = x[column];
            x[column] = x[best];
            x[best] = entry;
        }
        for (row = column + 1; row < COORDINATES; ++row) {
            const real factor
                = a[row * COORDINATES + column] / a[column * COORDINATES + column];
            for (k = column; k < COORDINATES; ++k) {
                a[row * COORDINATES + k] -= factor * a[column * COORDINATES + k];
            }
            x[row] -= factor * x[column];
        }
    }
    for (column = COORDINATES - 1; column >= 0; --column) {
        int row;
        x[column] /= a[column * COORDINATES + column];
        for (row = 0; row < column; ++row) {
            x[row] -= a[row * COORDINATES + column] * x[column];
        }
    }
    for (column = 0; column < COORDINATES; ++column) {
        x[column] /= units[column];
    }
    return are_finite(x, COORDINATES);
}

int @NAME@_accelerations(const @NAME@_params *params, @NAME@_state *warm,
    const real q[COORDINATES], const real qd[COORDINATES], const real tau[DRIVES],
    real qdd[COORDINATES], @NAME@_info *info)
{
    @NAME@_params model;
    @NAME@_state copy;
    real now[COORDINATES] = { 0 };
    int step;
    int k;
    if (warm == 0 || tau == 0 || qdd == 0 || !are_finite(tau, DRIVES)) {
        return @GUARD@_BAD_INPUT;
    }
    if (params == 0) {
        @NAME@_defaults(&model);
        params = &model;
    }
    /* A copy computes, so that the direction of the last motion does not change. */
    copy = *warm;
    for (step = 0; step < MOST_STEPS; ++step) {
        real found[ANSWERS];
        real needed[DRIVES];
        real w[SLOPE_WORK];
        real matrix[DRIVES * COORDINATES];
        real change[COORDINATES];
        int settled;
        const int code = answer(params, &copy, q, qd, now, 0, needed, found, info);
        if (code != @GUARD@_OK) {
            return code;
        }
        if (!linearize(params, &copy, q, qd, now, found, w) || !differentiate(w, 2, matrix)) {
            return @GUARD@_UNDETERMINED;
        }
        for (k = 0; k < DRIVES; ++k) {
            change[k] = tau[k] - needed[k];
        }
        settled = largest(change, DRIVES)
            <= RESIDUAL * (largest(tau, DRIVES) + largest(needed, DRIVES));
        if (!eliminate(matrix, change)) {
            return @GUARD@_SINGULAR;
        }
        for (k = 0; k < COORDINATES; ++k) {
            now[k] += change[k];
        }
        /* Newton steps square the error. */
        if (settled
            || largest(change, COORDINATES) <= SETTLED_STEP * largest(now, COORDINATES)) {
            for (k = 0; k < COORDINATES; ++k) {
                qdd[k] = now[k];
            }
            for (k = 0; k < TREE; ++k) {
                warm->tree[k] = copy.tree[k];
            }
            return code;
        }
    }
    return @GUARD@_FRICTIONLESS;
}
