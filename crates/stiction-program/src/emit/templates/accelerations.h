/* Forward dynamics: the accelerations qdd that the efforts tau cause in a motion with rates qd, with
   friction, by at most @STEPS@ Newton steps. @GUARD@_UNDETERMINED where joints rest: whether they
   stick or begin to slide is not decided here. @GUARD@_FRICTIONLESS where friction has no solution,
   or the steps do not converge; @GUARD@_SINGULAR where efforts do not determine the accelerations.
   Without @GUARD@_OK, qdd is unchanged. */
int @NAME@_accelerations(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real tau[@GUARD@_ACTUATORS], @NAME@_real qdd[@GUARD@_COORDINATES],
    @NAME@_info *info);

