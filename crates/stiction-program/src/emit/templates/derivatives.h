/* Like @NAME@_ff, with the derivatives of the efforts with respect to positions, rates and
   accelerations: a row for each actuator, a column for each coordinate. They are exact and include the
   change of friction with the reactions. The derivatives exist only with @GUARD@_OK; otherwise the
   matrices are unchanged. If a joint slides too slowly for derivatives, the code is
   @GUARD@_UNDETERMINED. */
int @NAME@_derivatives(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real qdd[@GUARD@_COORDINATES], @NAME@_real tau[@GUARD@_ACTUATORS],
    @NAME@_real by_q[@GUARD@_ACTUATORS * @GUARD@_COORDINATES],
    @NAME@_real by_qd[@GUARD@_ACTUATORS * @GUARD@_COORDINATES],
    @NAME@_real by_qdd[@GUARD@_ACTUATORS * @GUARD@_COORDINATES], @NAME@_info *info);

