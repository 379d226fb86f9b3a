/* Like @NAME@_ff, with the reaction of each joint: the force [N] of its first body on the second, then
   its moment about the joint's origin [N m], world axes. Reactions contain constraint, actuator
   and friction forces. Statically indeterminate components (stiction check lists them) follow from a
   rule; those of a real machine may differ. If the code is below 0, `reactions` is unchanged. */
int @NAME@_reactions(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real qdd[@GUARD@_COORDINATES], @NAME@_real tau[@GUARD@_ACTUATORS],
    @NAME@_real reactions[6 * @GUARD@_JOINTS], @NAME@_info *info);

