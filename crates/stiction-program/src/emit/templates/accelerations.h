/* Forward dynamics: the accelerations qdd that the efforts tau cause in a motion with rates qd, with
   friction, by at most @STEPS@ Newton steps. @GUARD@_UNDETERMINED if joints are at rest: this function does not
   decide whether they stick or begin to slide. @GUARD@_FRICTIONLESS if no solution with friction exists,
   or the steps do not converge; @GUARD@_SINGULAR if the efforts do not determine the accelerations.
   If the code is not @GUARD@_OK, qdd is unchanged. */
int @NAME@_accelerations(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real tau[@GUARD@_ACTUATORS], @NAME@_real qdd[@GUARD@_COORDINATES],
    @NAME@_info *info);

