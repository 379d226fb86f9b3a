/* As @NAME@_ff, and the derivatives of the efforts by positions, rates and accelerations: a row for
   each actuator, a column for each coordinate. They are exact and contain the change of friction
   with the reactions. Without @GUARD@_OK there are none, and the matrices are unchanged; that is also
   so where a joint slides too slowly for derivatives (@GUARD@_UNDETERMINED). */
int @NAME@_derivatives(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real qdd[@GUARD@_COORDINATES], @NAME@_real tau[@GUARD@_ACTUATORS],
    @NAME@_real by_q[@GUARD@_ACTUATORS * @GUARD@_COORDINATES],
    @NAME@_real by_qd[@GUARD@_ACTUATORS * @GUARD@_COORDINATES],
    @NAME@_real by_qdd[@GUARD@_ACTUATORS * @GUARD@_COORDINATES], @NAME@_info *info);

