/*
@LINES@ */
#include "@NAME@.h"

#include <math.h>

typedef @NAME@_real real;

#define COORDINATES @GUARD@_COORDINATES
#define DRIVES @GUARD@_ACTUATORS
#define JOINTS @GUARD@_JOINTS
#define TREE @GUARD@_TREE
/* Number of reaction components among the results for each joint, and number of results of a call. */
#define WRENCH @WRENCH@
#define ANSWERS @ANSWERS@
#define TUNABLES @TUNABLES@
#define UNKNOWNS @UNKNOWNS@
#define POSITION_WORK @POSITION_WORK@
#define POSITION_RESULTS @POSITION_RESULTS@
#define FORCE_WORK @FORCE_WORK@
#define FORCE_RESULTS @FORCE_RESULTS@
/* Largest numbers of iterations of the loop closure, of the coupled friction, and of the path from home. */
#define MOST_CORRECTIONS @CORRECTIONS@
#define MOST_STEPS @STEPS@
#define MOST_STRIDES 1000
/* First indices of the parts of the workspace of the forces. */
#define FIRST_TARGET (TREE + TUNABLES)
#define FIRST_UNKNOWN (FIRST_TARGET + 3 * COORDINATES)
/* Value of `ready` in an initialised state. */
#define READY 0x5713C710u

static const real HUGE_NUMBER = @HUGE@;
/* Closure error below which no further correction follows; larger error that is accepted if corrections no longer
   reduce it. */
static const real DONE = @DONE@;
static const real CLOSED = @CLOSED@;
/* Squares of relative changes: of a converged step; up to which convergence is quadratic; of rounding errors. */
static const real SETTLED = @SETTLED@;
static const real COARSE = @COARSE@;
static const real ROUNDING = @ROUNDING@;
/* Magnitude of the rates that represent the direction of incipient motion at rest. */
static const real CREEP = @REST@;

static const real HOME_TREE[TREE] = {
@HOME@
};

static const real HOME[COORDINATES] = {
@HOME_VALUES@
};

/* Largest change of each coordinate in one step of the path from home. */
static const real STRIDE[COORDINATES] = {
@STRIDES@
};

#if defined(__GNUC__) && __GNUC__ >= 8 && !defined(__clang__) && defined(__x86_64__)
/* GCC on x86-64: long straight-line code is faster without vectors and reordering, and smaller with a frame pointer; in the loops, a
   number that was written in a pair is read late in a longer vector. Other compilers need no such hints. */
#define STRAIGHT_LINE __attribute__((optimize("no-tree-slp-vectorize", "no-omit-frame-pointer", "no-schedule-insns2")))
#pragma GCC target("prefer-vector-width=128")
#else
#define STRAIGHT_LINE
#endif

static int is_finite(real x)
{
    return x >= -HUGE_NUMBER && x <= HUGE_NUMBER;
}

static int are_finite(const real *x, int count)
{
    int k;
    for (k = 0; k < count; ++k) {
        if (!is_finite(x[k])) {
            return 0;
        }
    }
    return 1;
}

static real largest(const real *x, int count)
{
    real most = 0;
    int k;
    for (k = 0; k < count; ++k) {
        const real size = fabs@F@(x[k]);
        most = size > most ? size : most;
    }
    return most;
}

@OWN_MATH@/* Closure error of the loops at w: r[0] is its square, r[1] is positive if the equations are valid. */
STRAIGHT_LINE static void find_errors(real *w, real *r)
{
@ERRORS@}

/* Corrected coordinates r of the tree; find_errors must have been called before. */
STRAIGHT_LINE static void correct(const real *w, real *r)
{
@CORRECTION@}

/* Computes everything that does not depend on friction. */
STRAIGHT_LINE static void prepare(real *w, real *r)
{
@PREPARATION@}

/* Newton step of the coupled friction forces and reactions. */
STRAIGHT_LINE static void couple(real *w, real *r)
{
@STEP@}

/* Actuator efforts and reactions. */
STRAIGHT_LINE static void find_forces(const real *w, real *r)
{
@FORCES@}

@SINGULARITY@
/* Closes the loops at q, starting from the coordinates `tree`, and updates `tree`; returns 0 if that fails. */
static int close_loops(real *tree, const real *q, real *residual, int *corrections)
{
    real w[POSITION_WORK];
    real r[POSITION_RESULTS];
    real before = HUGE_NUMBER;
    int pass;
    int k;
    for (k = 0; k < TREE; ++k) {
        w[k] = tree[k];
    }
    for (k = 0; k < COORDINATES; ++k) {
        w[TREE + k] = q[k];
    }
    for (pass = 0; pass <= MOST_CORRECTIONS; ++pass) {
        real error;
        find_errors(w, r);
        error = sqrt@F@(r[0]);
        if (!is_finite(error) || !(r[1] > 0)) {
            return 0;
        }
        *residual = error;
        *corrections = pass;
        if (error <= DONE || (error <= CLOSED && error >= before / 2)) {
            for (k = 0; k < TREE; ++k) {
                tree[k] = w[k];
            }
            return 1;
        }
        before = error;
        if (pass < MOST_CORRECTIONS) {
            correct(w, r);
            for (k = 0; k < TREE; ++k) {
                w[k] = r[k];
            }
        }
    }
    return 0;
}

/* Computes the efforts without friction for the coordinates in w; returns 0 if there are none. */
static int solve_ideal(real *w, real *r, real *ideal, @NAME@_info *info)
{
    int k;
    prepare(w, r);
    for (k = 0; k < DRIVES; ++k) {
        ideal[k] = r[UNKNOWNS + k];
    }
    for (k = DRIVES; k < ANSWERS; ++k) {
        ideal[k] = r[UNKNOWNS + 2 + k];
    }
    info->determinant = r[UNKNOWNS + DRIVES + 1];
    if (!is_finite(info->determinant)) {
        info->determinant = 0;
    }
    return info->determinant > 0 && are_finite(ideal, ANSWERS);
}

/* Computes the results with friction after solve_ideal; returns 0 if there is no solution. */
static int solve_friction(real *w, real *r, real *tau, @NAME@_info *info)
{
    real before = 0;
    real most = 0;
    int holds = r[UNKNOWNS + DRIVES] > 0;
    int settled = UNKNOWNS == 0;
    int step;
    int k;
    for (step = 0; step < MOST_STEPS; ++step) {
        real change;
        for (k = 0; k < UNKNOWNS; ++k) {
            w[FIRST_UNKNOWN + k] = r[k];
        }
        couple(w, r);
        ++info->steps;
        if (settled) {
            break;
        }
        change = r[UNKNOWNS] / r[UNKNOWNS + 1];
        /* Newton steps square the error, so the last two changes determine the remaining error. */
        settled = (change <= SETTLED
                      || (change < COARSE && change * change * change <= ROUNDING * before * before
                          && change * change * change <= ROUNDING))
            && r[UNKNOWNS + 2] > 0;
        before = change;
        if (settled) {
            break;
        }
    }
    info->coupling = is_finite(r[UNKNOWNS + 2]) ? r[UNKNOWNS + 2] : 0;
    find_forces(w, r);
    holds = holds && r[DRIVES + WRENCH * JOINTS] > 0;
    if (!settled || !holds || !are_finite(r, DRIVES + WRENCH * JOINTS)) {
        return 0;
    }
    for (k = 0; k < ANSWERS; ++k) {
        tau[k] = r[k];
    }
    for (k = 0; k < JOINTS; ++k) {
        const real *force = r + DRIVES + WRENCH * k;
        const real square = force[0] * force[0] + force[1] * force[1] + force[2] * force[2];
        if (square > most || k == 0) {
            most = square;
            info->joint = k;
        }
    }
    info->reaction = is_finite(most) ? sqrt@F@(most) : HUGE_NUMBER;
    return 1;
}

static void set_motion(real *w, const real *tree, const real *q, const real *rates, const real *qdd)
{
    int k;
    for (k = 0; k < TREE; ++k) {
        w[k] = tree[k];
    }
    for (k = 0; k < COORDINATES; ++k) {
        w[FIRST_TARGET + 3 * k] = q[k];
        w[FIRST_TARGET + 3 * k + 1] = rates[k];
        w[FIRST_TARGET + 3 * k + 2] = qdd[k];
    }
}

static void set_parameters(real *w, const @NAME@_params *params)
{
    w += TREE;
    (void)w;
    (void)params;
@TUNE@}

/* Sets rates of negligible size in a direction. */
static void creep(real *rates, const real *direction)
{
    const real size = largest(direction, COORDINATES);
    int k;
    for (k = 0; k < COORDINATES; ++k) {
        rates[k] = direction[k] / size * CREEP;
    }
}

unsigned @NAME@_identity(int item)
{
    switch (item) {
    case 0:
        return @GUARD@_FINGERPRINT_LOW;
    case 1:
        return @GUARD@_FINGERPRINT_HIGH;
    case 2:
        return (unsigned)sizeof(real);
    case 3:
        return (unsigned)sizeof(@NAME@_params);
    case 4:
        return (unsigned)sizeof(@NAME@_state);
    case 5:
        return (unsigned)sizeof(@NAME@_info);
    default:
        return 0;
    }
}

void @NAME@_defaults(@NAME@_params *params)
{
    if (params == 0) {
        return;
    }
@DEFAULTS@    params->rest_rate = @REST@;
    params->fade = @FADE@;
    params->rest = @GUARD@_HELD;
}

int @NAME@_init(@NAME@_state *state, const real q[COORDINATES])
{
    real tree[TREE];
    real far_away = 0;
    real residual = 0;
    int corrections = 0;
    int strides;
    int stride;
    int k;
    if (state == 0) {
        return @GUARD@_BAD_INPUT;
    }
    state->ready = 0;
    if (q == 0 || !are_finite(q, COORDINATES)) {
        return @GUARD@_BAD_INPUT;
    }
    for (k = 0; k < COORDINATES; ++k) {
        const real distance = fabs@F@(q[k] - HOME[k]) / STRIDE[k];
        far_away = distance > far_away ? distance : far_away;
    }
    if (!(far_away < MOST_STRIDES)) {
        return @GUARD@_OPEN;
    }
    strides = 1 + (int)far_away;
    for (k = 0; k < TREE; ++k) {
        tree[k] = HOME_TREE[k];
    }
    for (stride = 1; stride <= strides; ++stride) {
        real towards[COORDINATES];
        for (k = 0; k < COORDINATES; ++k) {
            const real part = (q[k] - HOME[k]) / (real)strides;
            towards[k] = stride < strides ? HOME[k] + part * (real)stride : q[k];
        }
        if (!close_loops(tree, towards, &residual, &corrections)) {
            return @GUARD@_OPEN;
        }
    }
    for (k = 0; k < TREE; ++k) {
        state->tree[k] = tree[k];
    }
    for (k = 0; k < DRIVES; ++k) {
        state->tau[k] = 0;
    }
    for (k = 0; k < COORDINATES; ++k) {
        state->direction[k] = 0;
    }
    state->weight = 0;
    fill(state->weakest);
    state->ready = READY;
    return @GUARD@_OK;
}

/* Computes efforts at closed loops; chooses the direction of motion at rest. The singularity index is left out if it is
   not wanted and the determinant is not small. */
static int solve(const @NAME@_params *params, @NAME@_state *warm, const real *tree, const real *q,
    const real *qd, const real *qdd, const real *direction, int wants_index, real *tau, @NAME@_info *info)
{
    real w[FORCE_WORK];
    real r[FORCE_RESULTS];
    real rates[COORDINATES];
    real with[ANSWERS];
    real weight = 1;
    int attempt;
    int has_friction = 1;
    int is_regular;
    int k;
    /* Direction in which motion begins if the mechanism is at rest now. */
    const real *next = direction != 0 && largest(direction, COORDINATES) > 0 ? direction : qdd;
    const real slow = params->rest_rate >= 0 ? params->rest_rate : 0;
    const int rests = largest(qd, COORDINATES) <= slow;
    const int has_next = next != qdd || largest(qdd, COORDINATES) > slow;
    for (k = 0; k < COORDINATES; ++k) {
        rates[k] = qd[k];
    }
    if (rests) {
        info->undetermined = 1;
        if (!has_next) {
            next = warm->direction;
            weight = params->rest == @GUARD@_FADED ? warm->weight * params->fade : warm->weight;
        }
        /* A factor that is NaN or out of bounds yields no friction. */
        if ((params->rest == @GUARD@_ZERO && !has_next) || !(weight >= 0 && weight <= 1)) {
            weight = 0;
        }
        if (largest(next, COORDINATES) > 0) {
            creep(rates, next);
        } else {
            weight = 0;
        }
    }
    set_parameters(w, params);
    set_motion(w, tree, q, rates, qdd);
    is_regular = solve_ideal(w, r, tau, info);
    if (wants_index || info->determinant < SMALL_DETERMINANT) {
        find_index(r + FIRST_PLACE, warm, info);
        is_regular = is_regular && info->singularity_index > LEAST_INDEX;
    }
    if (!is_regular) {
        return @GUARD@_SINGULAR;
    }
    if (weight > 0) {
        has_friction = solve_friction(w, r, with, info);
        for (attempt = 0; attempt < 1 && !has_friction && !rests; ++attempt) {
            /* A joint is at rest while others move, or no convergence: the accelerations give its direction. */
            real moved[COORDINATES];
            real ideal[ANSWERS];
            if (!(largest(next, COORDINATES) > 0)) {
                break;
            }
            creep(moved, next);
            for (k = 0; k < COORDINATES; ++k) {
                moved[k] += qd[k];
            }
            set_motion(w, tree, q, moved, qdd);
            has_friction = solve_ideal(w, r, ideal, info) && solve_friction(w, r, with, info);
            info->undetermined = has_friction;
        }
        for (k = 0; k < ANSWERS && has_friction; ++k) {
            tau[k] += weight * (with[k] - tau[k]);
        }
    }
    if (!has_friction) {
        info->fallback = 1;
    }
    if (!rests || has_next) {
        const real *last = rests ? next : qd;
        const real size = largest(last, COORDINATES);
        for (k = 0; k < COORDINATES; ++k) {
            warm->direction[k] = last[k] / size;
        }
        warm->weight = 1;
    } else {
        warm->weight = weight;
    }
    if (!has_friction) {
        return @GUARD@_FRICTIONLESS;
    }
    return info->undetermined ? @GUARD@_UNDETERMINED : @GUARD@_OK;
}

/* Like @NAME@_ff_towards, but returns all results. */
static int answer(const @NAME@_params *params, @NAME@_state *warm, const real *q, const real *qd,
    const real *qdd, const real *direction, real *tau, real *found, @NAME@_info *info)
{
    static const @NAME@_info NOTHING = { 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 2 };
    @NAME@_params model;
    @NAME@_info own = NOTHING;
    real tree[TREE];
    const int wants_index = info != 0;
    int code;
    int k;
    if (info == 0) {
        info = &own;
    }
    *info = NOTHING;
    if (warm == 0 || tau == 0) {
        return @GUARD@_BAD_INPUT;
    }
    if (warm->ready != READY) {
        for (k = 0; k < DRIVES; ++k) {
            tau[k] = 0;
        }
        return @GUARD@_NOT_READY;
    }
    for (k = 0; k < DRIVES; ++k) {
        tau[k] = warm->tau[k];
    }
    if (params == 0) {
        @NAME@_defaults(&model);
        params = &model;
    }
    if (q == 0 || qd == 0 || qdd == 0 || !are_finite(q, COORDINATES)
        || !are_finite(qd, COORDINATES) || !are_finite(qdd, COORDINATES)
        || (direction != 0 && !are_finite(direction, COORDINATES))) {
        return @GUARD@_BAD_INPUT;
    }
    for (k = 0; k < TREE; ++k) {
        tree[k] = warm->tree[k];
    }
    if (!close_loops(tree, q, &info->residual, &info->corrections)) {
        return @GUARD@_OPEN;
    }
    info->fallback = 0;
    code = solve(params, warm, tree, q, qd, qdd, direction, wants_index, found, info);
    if (code >= 0 && !are_finite(found, ANSWERS)) {
        code = @GUARD@_SINGULAR;
    }
    if (code < 0) {
        info->fallback = 2;
        return code;
    }
    for (k = 0; k < TREE; ++k) {
        warm->tree[k] = tree[k];
    }
    for (k = 0; k < DRIVES; ++k) {
        tau[k] = found[k];
        warm->tau[k] = found[k];
    }
    return code;
}

int @NAME@_ff_towards(const @NAME@_params *params, @NAME@_state *warm, const real q[COORDINATES],
    const real qd[COORDINATES], const real qdd[COORDINATES], const real direction[COORDINATES],
    real tau[DRIVES], @NAME@_info *info)
{
    real found[ANSWERS];
    return answer(params, warm, q, qd, qdd, direction, tau, found, info);
}

int @NAME@_ff(const @NAME@_params *params, @NAME@_state *warm, const real q[COORDINATES],
    const real qd[COORDINATES], const real qdd[COORDINATES], real tau[DRIVES], @NAME@_info *info)
{
    return @NAME@_ff_towards(params, warm, q, qd, qdd, 0, tau, info);
}

int @NAME@_hold(const @NAME@_params *params, @NAME@_state *warm, const real q[COORDINATES],
    const real direction[COORDINATES], real tau[DRIVES], @NAME@_info *info)
{
    static const real NONE[COORDINATES] = { 0 };
    @NAME@_params at_rest;
    @NAME@_state copy;
    int code;
    int k;
    if (warm == 0) {
        return @NAME@_ff_towards(params, warm, q, NONE, NONE, direction, tau, info);
    }
    if (params == 0) {
        @NAME@_defaults(&at_rest);
    } else {
        at_rest = *params;
    }
    at_rest.rest = @GUARD@_ZERO;
    /* Keeps the direction of the last motion. */
    copy = *warm;
    code = @NAME@_ff_towards(&at_rest, &copy, q, NONE, NONE, direction, tau, info);
    if (code >= 0) {
        for (k = 0; k < TREE; ++k) {
            warm->tree[k] = copy.tree[k];
        }
        for (k = 0; k < DRIVES; ++k) {
            warm->tau[k] = copy.tau[k];
        }
        for (k = 0; k < WIDTH * BODIES; ++k) {
            warm->weakest[k] = copy.weakest[k];
        }
    }
    if (code == @GUARD@_UNDETERMINED) {
        /* The direction is given, or there is no friction. */
        code = @GUARD@_OK;
        if (info != 0) {
            info->undetermined = 0;
        }
    }
    return code;
}
@REACTIONS@@KINEMATICS@@LINEARIZE@@DERIVATIVES@@ACCELERATIONS@