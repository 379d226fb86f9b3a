/*
@LINES@ */
#ifndef @GUARD@_H
#define @GUARD@_H

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#error "@NAME@ tests for NaN and infinity: compile without -ffast-math"
#elif defined(__FINITE_MATH_ONLY__)
#if __FINITE_MATH_ONLY__ > 0
#error "@NAME@ tests for NaN and infinity: compile without -ffinite-math-only"
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of coordinates, of actuators, of joints, of bodies that move, and of coordinates of the spanning tree. */
#define @GUARD@_COORDINATES @COORDINATES@
#define @GUARD@_ACTUATORS @DRIVES@
#define @GUARD@_JOINTS @JOINTS@
#define @GUARD@_BODIES @BODIES@
#define @GUARD@_TREE @TREE@
/* Low and high half of the fingerprint of the model. */
#define @GUARD@_FINGERPRINT_LOW @FINGERPRINT_LOW@
#define @GUARD@_FINGERPRINT_HIGH @FINGERPRINT_HIGH@

typedef @REAL@ @NAME@_real;

/* Return codes. With codes from 0 on, tau is the result of this call; with negative codes, tau is the last result
   stored in the state, or zero with @GUARD@_NOT_READY. */
enum {
    /* Success. */
    @GUARD@_OK = 0,
    /* Success, but a rule chose the direction of friction, see `rest`: joints are at rest, or friction did not
       converge with the direction of the rates. */
    @GUARD@_UNDETERMINED = 1,
    /* The efforts do not include friction: friction has no solution (it locks the mechanism), a joint is at
       rest while others move, or the position is far from those for which the code was generated. */
    @GUARD@_FRICTIONLESS = 2,
    /* An input is NaN or infinite, or a pointer is null. */
    @GUARD@_BAD_INPUT = -1,
    /* The loops cannot be closed, starting from the last position: out of reach, or too far in one step. */
    @GUARD@_OPEN = -2,
    /* The position is singular, or a singular position lies between it and the home position. */
    @GUARD@_SINGULAR = -3,
    /* @NAME@_init has not been called, or has failed. */
    @GUARD@_NOT_READY = -4
};

/* Rules for friction at rest, while all rates and accelerations are zero. */
enum {
    /* Friction opposes the direction of the last motion. */
    @GUARD@_HELD = 0,
    /* Friction opposes the direction of the last motion. Every call at rest multiplies the friction by `fade`. */
    @GUARD@_FADED = 1,
    /* No friction. */
    @GUARD@_ZERO = 2
};

/* Parameters that can be changed between calls. @NAME@_defaults sets those of the model. */
typedef struct @NAME@_params {
@FIELDS@    /* Rates and accelerations up to this magnitude count as zero [SI units]. */
    @NAME@_real rest_rate;
    /* Factor, from 0 to 1, by which every call at rest multiplies the friction with rest = @GUARD@_FADED. */
    @NAME@_real fade;
    /* Rule for friction at rest: @GUARD@_HELD, @GUARD@_FADED or @GUARD@_ZERO. */
    int rest;
} @NAME@_params;

/* State that is kept from one call to the next. Callers must not use its fields. */
typedef struct @NAME@_state {
    @NAME@_real tree[@GUARD@_TREE];
    @NAME@_real tau[@GUARD@_ACTUATORS];
    @NAME@_real direction[@GUARD@_COORDINATES];
    @NAME@_real weight;
    @NAME@_real weakest[12 * @GUARD@_BODIES];
    unsigned ready;
} @NAME@_state;

/* Details about the result of a call. */
typedef struct @NAME@_info {
    /* Closure error of the loops: lengths are divided by the characteristic length, angles are in rad. */
    @NAME@_real residual;
    /* Singularity index (type 2, actuation): smallest singular value of the dimensionless balance of all bodies, with
       a characteristic length of @LENGTH@ m. It is 0 if some motion is resisted by no actuator and no constraint, and
       if the call has no result. */
    @NAME@_real singularity_index;
    /* Determinant of the equations relative to that at the home position: positive on the same side of all singular
       positions as the home position, 0 if the coordinates or the actuators do not determine the motion. */
    @NAME@_real determinant;
    /* Determinant of the force balance with friction, relative to that without friction: 0 if friction locks the
       mechanism. */
    @NAME@_real coupling;
    /* Largest reaction force of all joints [N], and the index of the joint with this force; 0 and -1 if the efforts
       do not include friction. */
    @NAME@_real reaction;
    int joint;
    /* Number of position corrections in the loop closure, at most @CORRECTIONS@; number of Newton steps for the
       coupled friction forces and reactions, at most 2 x @STEPS@. */
    int corrections;
    int steps;
    /* Number of iterations (passes) of the singularity index, at most @INDEX_PASSES@. */
    int index_passes;
    /* 1 if joints are at rest and a rule chose the direction of friction, else 0. */
    int undetermined;
    /* 1 if tau does not include friction, 2 if tau is the last result stored in the state, else 0. */
    int fallback;
} @NAME@_info;

/* Identifies the compiled code for callers that load it as a library and lay out its structures themselves. Items:
   0 and 1, low and high half of the fingerprint; 2 to 5, sizes of @NAME@_real, @NAME@_params, @NAME@_state and
   @NAME@_info in bytes. Returns 0 for other items. */
unsigned @NAME@_identity(int item);

/* Sets the parameters of the model. */
void @NAME@_defaults(@NAME@_params *params);

/* Closes the loops at the positions q, in steps on a straight line from the home position. Returns @GUARD@_OK,
   @GUARD@_OPEN or @GUARD@_BAD_INPUT. */
int @NAME@_init(@NAME@_state *state, const @NAME@_real q[@GUARD@_COORDINATES]);

/* Computes the actuator efforts tau for positions q, rates qd and accelerations qdd. `params` may
   be null, which selects the parameters of the model; `info` may be null. */
int @NAME@_ff(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real qdd[@GUARD@_COORDINATES], @NAME@_real tau[@GUARD@_ACTUATORS],
    @NAME@_info *info);

/* Computes the efforts as @NAME@_ff does. At rest, friction opposes the rates `direction`, of which only the ratios
   count. If `direction` is null or zero, friction at rest opposes the motion that begins with the accelerations; if
   these vanish too, `rest` applies. */
int @NAME@_ff_towards(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real qd[@GUARD@_COORDINATES],
    const @NAME@_real qdd[@GUARD@_COORDINATES], const @NAME@_real direction[@GUARD@_COORDINATES],
    @NAME@_real tau[@GUARD@_ACTUATORS], @NAME@_info *info);

/* Computes the efforts that hold the position q at rest, against weight and springs. With a `direction` of rates, of
   which only the ratios count, the efforts also overcome the friction of a motion that begins in this direction. If
   `direction` is null or zero, the efforts contain no friction. */
int @NAME@_hold(const @NAME@_params *params, @NAME@_state *warm,
    const @NAME@_real q[@GUARD@_COORDINATES], const @NAME@_real direction[@GUARD@_COORDINATES],
    @NAME@_real tau[@GUARD@_ACTUATORS], @NAME@_info *info);

@REACTIONS_HEAD@@KINEMATICS_HEAD@@DERIVATIVES_HEAD@@ACCELERATIONS_HEAD@#ifdef __cplusplus
}
#endif

#endif
