/* Answers the states of a file: positions, rates and accelerations in; code, determinant with friction, condition,
   singularity index and efforts out. */
#include "NAME.h"
#include <math.h>
#include <stdio.h>

#define COUNT UPPER_COORDINATES
#define DRIVES UPPER_ACTUATORS

/* Relative change of an input: small against the state, large against rounding errors in double precision. */
#define CHANGE 1e-7

/* Least size of each position in its relative change: 1 rad or the characteristic length, since positions are
   computed from numbers of this size. */
static const double SIZES[COUNT] = { POSITION_SIZES };

static double largest(const NAME_real *x, int count)
{
    double most = 0;
    int k;
    for (k = 0; k < count; ++k) {
        most = fmax(most, fabs((double)x[k]));
    }
    return most;
}

/* Condition number: sum of the changes of the efforts, relative to the largest effort, over the relative change of each
   input. Rounding of the inputs alone causes an error of this number times the unit roundoff. Infinite if a changed
   input has no efforts. */
static double condition(const NAME_state *state, const NAME_real *motion, const NAME_real *tau)
{
    NAME_real moved[3 * COUNT], changed[DRIVES], moves[DRIVES];
    double sum = 0;
    int input, k;
    for (input = 0; input < 3 * COUNT; ++input) {
        NAME_state copy = *state;
        const double size = input < COUNT
            ? fmax(fabs((double)motion[input]), SIZES[input])
            : largest(motion + input / COUNT * COUNT, COUNT);
        for (k = 0; k < 3 * COUNT; ++k) {
            moved[k] = motion[k];
        }
        moved[input] += (NAME_real)(CHANGE * size);
        if (NAME_ff(0, &copy, moved, moved + COUNT, moved + 2 * COUNT, changed, 0) != UPPER_OK) {
            return HUGE_VAL;
        }
        for (k = 0; k < DRIVES; ++k) {
            moves[k] = changed[k] - tau[k];
        }
        sum += largest(moves, DRIVES) / fmax(largest(tau, DRIVES), 1e-300);
    }
    return sum / CHANGE;
}

int main(void)
{
    double row[3 * COUNT], result[4 + DRIVES];
    long rows = 0;
    FILE *states = fopen("states.bin", "rb");
    FILE *answers = fopen("answers.bin", "wb");
    if (states == NULL || answers == NULL) {
        return 2;
    }
    while (fread(row, sizeof row[0], 3 * COUNT, states) == 3 * COUNT) {
        NAME_state state;
        NAME_real motion[3 * COUNT], tau[DRIVES];
        NAME_info info = { 0 };
        int code, k;
        for (k = 0; k < 3 * COUNT; ++k) {
            motion[k] = (NAME_real)row[k];
        }
        for (k = 0; k < DRIVES; ++k) {
            tau[k] = 0;
        }
        code = NAME_init(&state, motion);
        if (code == UPPER_OK) {
            code = NAME_ff(0, &state, motion, motion + COUNT, motion + 2 * COUNT, tau, &info);
        }
        result[0] = code;
        result[1] = (double)info.coupling;
        result[3] = (double)info.singularity_index;
        /* The change is not above rounding errors in single precision. */
        result[2] = 0;
        if (code == UPPER_OK && sizeof tau[0] == sizeof result[0]) {
            result[2] = fmin(condition(&state, motion, tau), 1e300);
        }
        for (k = 0; k < DRIVES; ++k) {
            result[4 + k] = (double)tau[k];
        }
        if (fwrite(result, sizeof result[0], 4 + DRIVES, answers) != 4 + DRIVES) {
            return 2;
        }
        ++rows;
    }
    fclose(states);
    printf("%ld rows\n", rows);
    return fclose(answers) != 0;
}
