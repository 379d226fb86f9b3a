
int @NAME@_derivatives(const @NAME@_params *params, @NAME@_state *warm, const real q[COORDINATES],
    const real qd[COORDINATES], const real qdd[COORDINATES], real tau[DRIVES],
    real by_q[DRIVES * COORDINATES], real by_qd[DRIVES * COORDINATES],
    real by_qdd[DRIVES * COORDINATES], @NAME@_info *info)
{
    @NAME@_params model;
    real found[ANSWERS];
    real w[SLOPE_WORK];
    real matrices[3][DRIVES * COORDINATES];
    int code = @GUARD@_BAD_INPUT;
    int k;
    if (by_q == 0 || by_qd == 0 || by_qdd == 0) {
        return code;
    }
    if (params == 0) {
        @NAME@_defaults(&model);
        params = &model;
    }
    code = answer(params, warm, q, qd, qdd, 0, tau, found, info);
    if (code != @GUARD@_OK) {
        return code;
    }
    if (!linearize(params, warm, q, qd, qdd, found, w) || !differentiate(w, 0, matrices[0])
        || !differentiate(w, 1, matrices[1]) || !differentiate(w, 2, matrices[2])) {
        return @GUARD@_UNDETERMINED;
    }
    for (k = 0; k < DRIVES * COORDINATES; ++k) {
        by_q[k] = matrices[0][k];
        by_qd[k] = matrices[1][k];
        by_qdd[k] = matrices[2][k];
    }
    return code;
}
