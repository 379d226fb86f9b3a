/*
 * Self-test of @NAME@: reproduces the test vectors, which come from the general solver of stiction,
 * not from this code. Returns 0 if all agree.
 */
#include "@NAME@.h"

#include <stdio.h>
#include <stdlib.h>

#define COORDINATES @GUARD@_COORDINATES
#define DRIVES @GUARD@_ACTUATORS
/* 1 if loops keep the first coordinate from values far away. */
#define BOUNDED @BOUNDED@
#define NUMBERS (3 * COORDINATES + DRIVES)

/* Largest difference, relative to the largest effort of the sample. */
static const double TOLERANCE = @TOLERANCE@;
/* The pivots are those of the home position. In single precision, they magnify rounding errors near some other
   positions: in one row of a hundred, the difference may be larger by this factor. In double precision, it is 1. */
static const double MAGNIFIED = @MAGNIFIED@;

static double size_of(double x)
{
    return x < 0 ? -x : x;
}

/* Reads a row of numbers; returns 0 at the end of the file or for another row. */
static int read_row(FILE *file, double *numbers)
{
    static char line[32 * NUMBERS + 256];
    char *at = line;
    int k;
    if (fgets(line, (int)sizeof line, file) == NULL) {
        return 0;
    }
    for (k = 0; k < NUMBERS; ++k) {
        char *end = at;
        numbers[k] = strtod(at, &end);
        if (end == at) {
            return 0;
        }
        at = *end == ',' ? end + 1 : end;
    }
    return 1;
}

/* Returns 1 if NaN and positions out of reach are rejected and efforts remain finite. */
static int refuses_bad_input(@NAME@_state *state, const @NAME@_real *q)
{
    const @NAME@_real zero = 0;
    @NAME@_real bad[COORDINATES] = { 0 };
    @NAME@_real still[COORDINATES] = { 0 };
    @NAME@_real tau[DRIVES];
    int k;
    bad[0] = zero / zero;
    if (@NAME@_ff(NULL, state, q, bad, still, tau, NULL) != @GUARD@_BAD_INPUT
        || @NAME@_ff(NULL, state, q, still, bad, tau, NULL) != @GUARD@_BAD_INPUT
        || @NAME@_ff(NULL, state, bad, still, still, tau, NULL) != @GUARD@_BAD_INPUT) {
        return 0;
    }
    for (k = 0; k < DRIVES; ++k) {
        if (!(tau[k] - tau[k] == 0)) {
            return 0;
        }
    }
    bad[0] = (@NAME@_real)1e30;
    k = @NAME@_ff(NULL, state, bad, still, still, tau, NULL);
    return (k < 0 || !BOUNDED) && tau[0] - tau[0] == 0;
}

int main(int count, char **arguments)
{
    const char *path = count > 1 ? arguments[1] : "vectors.csv";
    FILE *file = fopen(path, "r");
    double numbers[NUMBERS];
    double worst = 0;
    long rows = 0;
    long failures = 0;
    long magnified = 0;
    int c;
    if (file == NULL) {
        printf("cannot open %s\n", path);
        return 2;
    }
    do {
        c = fgetc(file);
    } while (c != '\n' && c != EOF);
    while (read_row(file, numbers)) {
        @NAME@_state state;
        @NAME@_info info;
        @NAME@_real q[COORDINATES];
        @NAME@_real qd[COORDINATES];
        @NAME@_real qdd[COORDINATES];
        @NAME@_real tau[DRIVES];
        double scale = 0;
        double difference = 0;
        int code;
        int k;
        for (k = 0; k < COORDINATES; ++k) {
            q[k] = (@NAME@_real)numbers[k];
            qd[k] = (@NAME@_real)numbers[COORDINATES + k];
            qdd[k] = (@NAME@_real)numbers[2 * COORDINATES + k];
        }
        code = @NAME@_init(&state, q);
        if (code == @GUARD@_OK) {
            code = @NAME@_ff(NULL, &state, q, qd, qdd, tau, &info);
        }
        ++rows;
        if (code != @GUARD@_OK) {
            printf("row %ld: code %d\n", rows, code);
            ++failures;
            continue;
        }
        for (k = 0; k < DRIVES; ++k) {
            const double expected = numbers[3 * COORDINATES + k];
            const double apart = size_of((double)tau[k] - expected);
            scale = size_of(expected) > scale ? size_of(expected) : scale;
            difference = apart > difference ? apart : difference;
        }
        difference = scale > 0 ? difference / scale : difference;
        worst = difference > worst ? difference : worst;
        if (!(difference <= TOLERANCE)) {
            printf("row %ld: relative difference %g\n", rows, difference);
            if (difference <= MAGNIFIED * TOLERANCE) {
                ++magnified;
            } else {
                ++failures;
            }
        }
        if (rows == 1 && !refuses_bad_input(&state, q)) {
            printf("NaN or a position out of reach is not refused\n");
            ++failures;
        }
    }
    fclose(file);
    if (rows == 0) {
        printf("%s has no rows\n", path);
        return 2;
    }
    if (magnified > 1 + rows / 100) {
        failures += magnified;
    }
    printf("@NAME@: %ld test vectors, %ld failures, largest relative difference %.1e\n", rows,
        failures, worst);
    return failures == 0 ? 0 : 1;
}
