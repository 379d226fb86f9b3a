
int @NAME@_reactions(const @NAME@_params *params, @NAME@_state *warm, const real q[COORDINATES],
    const real qd[COORDINATES], const real qdd[COORDINATES], real tau[DRIVES],
    real reactions[6 * JOINTS], @NAME@_info *info)
{
    real found[ANSWERS];
    int code = @GUARD@_BAD_INPUT;
    int k;
    if (reactions == 0) {
        return code;
    }
    code = answer(params, warm, q, qd, qdd, 0, tau, found, info);
    for (k = 0; k < 6 * JOINTS && code >= 0; ++k) {
        reactions[k] = found[DRIVES + k];
    }
    return code;
}
