/* Forward kinematics: closes the loops at q, starting from the position of the last call, and writes
   for each body the position of its origin [m], then the rows of its rotation matrix, body to
   world. The rotation of a body that can spin freely depends on the path to q. Returns a code; below
   0, `poses` is unchanged. */
int @NAME@_poses(@NAME@_state *warm, const @NAME@_real q[@GUARD@_COORDINATES],
    @NAME@_real poses[12 * @GUARD@_BODIES]);

/* Twists at positions q and rates qd: for each body the velocity of its origin [m/s], then its
   angular velocity [rad/s], world axes. */
int @NAME@_twists(@NAME@_state *warm, const @NAME@_real q[@GUARD@_COORDINATES],
    const @NAME@_real qd[@GUARD@_COORDINATES], @NAME@_real twists[6 * @GUARD@_BODIES]);

/* Jacobian of a body, 0 to @GUARD@_BODIES - 1: its twist per unit rate of each coordinate. Six
   rows for the components of the twist, a column for each coordinate; row by row. */
int @NAME@_jacobian(@NAME@_state *warm, const @NAME@_real q[@GUARD@_COORDINATES], int body,
    @NAME@_real jacobian[6 * @GUARD@_COORDINATES]);

