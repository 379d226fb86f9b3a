component @NAME@_hal "Feed-forward with joint friction, from reference motions to actuator efforts";
description """
Written by stiction; the code is yours. While ff-enable is false, efforts are zero. When it becomes true, the loops
are closed in up to 1000 steps from the home position, which may take longer than a period: set ff-enable before the
motion begins.
""";
pin in bit ff-enable "Computes efforts";
pin in float ref-position-#[@COORDINATES@] "Positions of the reference";
pin in float ref-rate-#[@COORDINATES@] "Rates of the reference";
pin in float ref-acceleration-#[@COORDINATES@] "Accelerations of the reference";
pin out float ff-effort-#[@DRIVES@] "Actuator efforts";
pin out s32 ff-code "Return code of the last call";
pin out float ff-residual "Closure error of the loops";
pin out float ff-singularity-index "Singularity index, 0 if some motion is resisted by no actuator";
pin out float ff-determinant "Determinant relative to that at the home position, 0 at singular positions";
@HAL_TUNABLES@option singleton yes;
option extra_setup yes;
function _ fp "Computes the efforts.";
license "GPL";
;;
@HEADER_TEXT@
@CODE_TEXT@
static @NAME@_params all_params;
static @NAME@_state all_state;
static int has_begun;

EXTRA_SETUP()
{
    int k = 0;
    (void)prefix;
    (void)extra_arg;
    (void)k;
    @NAME@_defaults(&all_params);
@HAL_DEFAULTS@    return 0;
}

FUNCTION(_)
{
    @NAME@_info details;
    real q[COORDINATES];
    real qd[COORDINATES];
    real qdd[COORDINATES];
    real tau[DRIVES] = { 0 };
    int outcome = @GUARD@_NOT_READY;
    int k;
    for (k = 0; k < COORDINATES; ++k) {
        q[k] = (real)ref_position(k);
        qd[k] = (real)ref_rate(k);
        qdd[k] = (real)ref_acceleration(k);
    }
@HAL_TUNE@    if (!ff_enable) {
        has_begun = 0;
    } else if (!has_begun) {
        outcome = @NAME@_init(&all_state, q);
        has_begun = outcome == @GUARD@_OK;
    }
    if (has_begun) {
        outcome = @NAME@_ff(&all_params, &all_state, q, qd, qdd, tau, &details);
        ff_residual = details.residual;
        ff_singularity_index = details.singularity_index;
        ff_determinant = details.determinant;
    }
    ff_code = outcome;
    for (k = 0; k < DRIVES; ++k) {
        ff_effort(k) = tau[k];
    }
}
