/* Kinematics, reactions, holding efforts, loads and forward dynamics against numbers of the solver;
   derivatives against differences of efforts. */
#include "NAME.h"
#include <math.h>
#include <stdio.h>

#define COUNT UPPER_COORDINATES
#define DRIVES UPPER_ACTUATORS
#define JOINTS UPPER_JOINTS
#define BODIES UPPER_BODIES

typedef NAME_real real;

static const double data[ROWS][WIDTH] = {
DATA};

static int failures = 0;

/* Compares with expected numbers, relative to the largest of them or to `size`. */
static void compare(const char *what, const real *found, const double *expected, int count, double size)
{
    double most = size;
    double apart = 0;
    const double bound = sizeof(real) == 8 ? 1e-10 : 2e-4;
    int k;
    for (k = 0; k < count; ++k) {
        most = fmax(most, fabs(expected[k]));
        apart = fmax(apart, fabs((double)found[k] - expected[k]));
    }
    if (!(apart <= bound * most)) {
        printf("%s: %g of %g\n", what, apart, most);
        ++failures;
    }
}

/* Differences of the efforts by one kind of input, of fourth order; returns the largest effort. */
static double difference(NAME_state *state, const real *at[3], int kind, double step, double *found)
{
    static const double weights[] = { 1. / 12, -8. / 12, 0, 8. / 12, -1. / 12 };
    double size = 0;
    int row, column, side;
    for (column = 0; column < COUNT; ++column) {
        for (row = 0; row < DRIVES; ++row) {
            found[row * COUNT + column] = 0;
        }
        for (side = -2; side <= 2; ++side) {
            real moved[3][COUNT], tau[DRIVES];
            for (row = 0; row < COUNT; ++row) {
                moved[0][row] = at[0][row];
                moved[1][row] = at[1][row];
                moved[2][row] = at[2][row];
            }
            moved[kind][column] += (real)(side * step);
            failures += NAME_ff(0, state, moved[0], moved[1], moved[2], tau, 0) != UPPER_OK;
            for (row = 0; row < DRIVES; ++row) {
                found[row * COUNT + column] += weights[side + 2] * (double)tau[row] / step;
                size = fmax(size, fabs((double)tau[row]));
            }
        }
    }
    return size;
}

/* Derivatives by one kind of input, against differences. Doubling the step shows the error of the
   differences, which is large near singular positions; rounding adds 1e-13 of the efforts over the step. */
static void differences(NAME_state *state, const real *at[3], int kind, const real *found)
{
    const double step = 2e-5;
    double fine[DRIVES * COUNT], coarse[DRIVES * COUNT];
    const double size = difference(state, at, kind, step, fine);
    int k;
    difference(state, at, kind, 2 * step, coarse);
    for (k = 0; k < DRIVES * COUNT; ++k) {
        const double bound = fabs(fine[k] - coarse[k]) + 1e-13 / step * size;
        if (!(fabs((double)found[k] - fine[k]) <= bound)) {
            printf("derivative %d by input %d: %g instead of %g\n", k, kind, (double)found[k], fine[k]);
            ++failures;
        }
    }
}

int main(void)
{
    static const real wrench[6] = { WRENCH };
    static real by[3][DRIVES * COUNT];
    NAME_params params;
    static real reactions[6 * JOINTS], poses[12 * BODIES], twists[6 * BODIES], jacobian[6 * COUNT];
    static real other[6 * BODIES];
    real q[COUNT], qd[COUNT], qdd[COUNT], slow[COUNT], none[COUNT], tau[DRIVES], begins[DRIVES];
    NAME_state state;
    NAME_info info;
    int row, k, body;
    for (row = 0; row < ROWS; ++row) {
        const double *at = data[row];
        double expected[6], begun[DRIVES > COUNT ? DRIVES : COUNT];
        for (k = 0; k < COUNT; ++k) {
            q[k] = (real)at[k];
            qd[k] = (real)at[COUNT + k];
            qdd[k] = (real)at[2 * COUNT + k];
            slow[k] = qd[k] * (real)1e-5;
            none[k] = 0;
        }
        if (NAME_poses(&state, q, 0) != UPPER_BAD_INPUT || NAME_init(&state, q) != UPPER_OK
            || NAME_poses(&state, q, poses) != UPPER_OK
            || NAME_twists(&state, q, qd, twists) != UPPER_OK
            || NAME_hold(0, &state, q, 0, begins, &info) != UPPER_OK || info.undetermined != 0
            || NAME_reactions(0, &state, q, qd, qdd, tau, reactions, &info) != UPPER_OK) {
            printf("row %d: a function failed\n", row);
            return 1;
        }
        at += 3 * COUNT;
        compare("efforts", tau, at, DRIVES, 0);
        {
            const real *motion[3];
            real again[DRIVES], found[COUNT], efforts[DRIVES];
            double size = 10;
            motion[0] = q;
            motion[1] = qd;
            motion[2] = qdd;
            if (NAME_derivatives(0, &state, q, qd, qdd, again, by[0], by[1], by[2], &info) != UPPER_OK) {
                printf("row %d: no derivatives\n", row);
                return 1;
            }
            compare("efforts with derivatives", again, at, DRIVES, 0);
            for (k = 0; k < DRIVES; ++k) {
                efforts[k] = (real)at[k];
            }
            for (k = 0; k < 3 && sizeof(real) == 8; ++k) {
                differences(&state, motion, k, by[k]);
            }
            if (NAME_accelerations(0, &state, q, qd, efforts, found, &info) != UPPER_OK) {
                printf("row %d: no accelerations\n", row);
                return 1;
            }
            for (k = 0; k < COUNT; ++k) {
                begun[k] = (double)qdd[k];
            }
            /* Rounding of efforts that contain weight and friction: larger in accelerations. */
            compare("accelerations", found, begun, COUNT, 100 * size);
            /* At rest nothing is decided. */
            failures += NAME_accelerations(0, &state, q, none, efforts, found, &info) != UPPER_UNDETERMINED;
            failures += NAME_derivatives(0, &state, q, none, none, again, by[0], by[1], by[2], &info)
                != UPPER_UNDETERMINED;
            efforts[0] = (real)NAN;
            failures += NAME_accelerations(0, &state, q, qd, efforts, found, &info) != UPPER_BAD_INPUT;
        }
        at += DRIVES;
        NAME_defaults(&params);
        for (k = 0; k < 6; ++k) {
            params.wrench[k] = wrench[k];
        }
        if (NAME_ff(&params, &state, q, qd, qdd, tau, &info) != UPPER_OK) {
            return 1;
        }
        compare("efforts under a load", tau, at, DRIVES, 0);
        at += DRIVES;
        compare("reactions", reactions, at, 6 * JOINTS, 0);
        at += 6 * JOINTS;
        compare("hold", begins, at, DRIVES, 0);
        at += DRIVES;
        compare("poses", poses, at, 12 * BODIES, 0);
        at += 12 * BODIES;
        compare("twists", twists, at, 6 * BODIES, 0);
        /* The Jacobian times the rates is the twist. */
        for (body = 0; body < BODIES; ++body) {
            double size = 0;
            if (NAME_jacobian(&state, q, body, jacobian) != UPPER_OK) {
                return 1;
            }
            for (k = 0; k < 6 * BODIES; ++k) {
                size = fmax(size, fabs(at[k]));
            }
            for (k = 0; k < 6; ++k) {
                int column;
                expected[k] = 0;
                for (column = 0; column < COUNT; ++column) {
                    expected[k] += (double)jacobian[k * COUNT + column] * (double)qd[column];
                }
            }
            compare("jacobian", twists + 6 * body, expected, 6, size);
        }
        /* Holding with a direction is a motion that begins in it: velocities change the efforts by a
           part of 1e-10. In single precision such rates count as rest. */
        if (sizeof(real) == 8) {
            double size = 0;
            if (NAME_hold(0, &state, q, qd, begins, &info) != UPPER_OK
                || NAME_ff(0, &state, q, slow, none, tau, &info) != UPPER_OK) {
                return 1;
            }
            for (k = 0; k < DRIVES; ++k) {
                begun[k] = (double)tau[k];
                size = fmax(size, fabs(begun[k]));
            }
            compare("begins", begins, begun, DRIVES, 1e4 * size);
        }
    }
    if (NAME_jacobian(&state, q, BODIES, jacobian) != UPPER_BAD_INPUT
        || NAME_jacobian(&state, q, -1, jacobian) != UPPER_BAD_INPUT) {
        return 1;
    }
    q[0] = (real)NAN;
    for (k = 0; k < 6 * BODIES; ++k) {
        other[k] = twists[k];
    }
    if (NAME_twists(&state, q, qd, twists) != UPPER_BAD_INPUT) {
        return 1;
    }
    for (k = 0; k < 6 * BODIES; ++k) {
        failures += other[k] != twists[k];
    }
    state.ready = 0;
    failures += NAME_poses(&state, qd, poses) != UPPER_NOT_READY;
    printf("%d failures\n", failures);
    return failures != 0;
}
