/* Time of a call along a smooth motion at 1 kHz, the best of several rounds. */
#define _POSIX_C_SOURCE 199309L
#include "NAME.h"
#include <math.h>
#include <stdio.h>
#include <time.h>

#define COUNT UPPER_COORDINATES
#define ROUNDS 21
#define CALLS 2000

#ifndef DETAILS
#define DETAILS &info
#endif

int main(void)
{
    static const double home[COUNT] = { HOME };
    NAME_params params;
    NAME_state state;
    NAME_info info = { 0 };
    double q[COUNT], v[COUNT], a[COUNT], tau[UPPER_ACTUATORS];
    double best = 1e30, sum = 0;
    long corrections = 0, steps = 0;
    int round, k, i, bad = 0;
    NAME_defaults(&params);
    for (round = 0; round < ROUNDS; ++round) {
        struct timespec begun, ended;
        double time;
        bad += NAME_init(&state, home) != 0;
        clock_gettime(CLOCK_MONOTONIC, &begun);
        for (k = 0; k < CALLS; ++k) {
            for (i = 0; i < COUNT; ++i) {
                const double t = 0.001 * k * (1 + 0.2 * i);
                q[i] = home[i] + 0.02 * sin(t);
                v[i] = 0.02 * cos(t);
                a[i] = -0.02 * sin(t);
            }
            bad += NAME_ff(&params, &state, q, v, a, tau, DETAILS) != 0;
            sum += tau[0];
            corrections += info.corrections;
            steps += info.steps;
        }
        clock_gettime(CLOCK_MONOTONIC, &ended);
        time = (double)(ended.tv_sec - begun.tv_sec) * 1e9
            + (double)(ended.tv_nsec - begun.tv_nsec);
        best = time / CALLS < best ? time / CALLS : best;
    }
    printf("%.0f ns, %.2f corrections, %.2f steps, sum %.17g\n", best,
        (double)corrections / (ROUNDS * CALLS), (double)steps / (ROUNDS * CALLS), sum);
    return bad;
}
