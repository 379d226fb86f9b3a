/* Behaviour at rest, at reversals and for impossible inputs. */
#include "NAME.h"
#include <math.h>
#include <stdio.h>

#define COUNT UPPER_COORDINATES
#define DRIVES UPPER_ACTUATORS

static int failures = 0;

#define CHECK(condition) \
    do { \
        if (!(condition)) { \
            printf("line %d: %s\n", __LINE__, #condition); \
            ++failures; \
        } \
    } while (0)

static const double home[COUNT] = { HOME };
static const double zero[COUNT] = { 0 };

static double apart(const double *a, const double *b)
{
    double most = 0;
    int k;
    for (k = 0; k < DRIVES; ++k) {
        most = fmax(most, fabs(a[k] - b[k]));
    }
    return most;
}

static int finite_all(const double *x, int count)
{
    int k;
    for (k = 0; k < count; ++k) {
        if (!(x[k] - x[k] == 0)) {
            return 0;
        }
    }
    return 1;
}

static unsigned long long seed = 7;

static double uniform(void)
{
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(seed >> 11) / 9007199254740992.0 * 2 - 1;
}

/* Friction at rest. */
static void rest(void)
{
    NAME_params params;
    NAME_state state;
    NAME_info info;
    double up[COUNT], down[COUNT], slow[COUNT];
    double moving[DRIVES], found[DRIVES], held[DRIVES], ideal[DRIVES], other[DRIVES];
    int k;
    NAME_defaults(&params);
    for (k = 0; k < COUNT; ++k) {
        up[k] = 0.3 + 0.1 * k;
        down[k] = -up[k];
        slow[k] = 1e-6 * up[k];
    }
    CHECK(NAME_init(&state, home) == UPPER_OK);
    /* Never moved: no direction, no friction. */
    CHECK(NAME_ff(&params, &state, home, zero, zero, ideal, &info) == UPPER_UNDETERMINED);
    CHECK(info.undetermined == 1 && info.fallback == 0);
    CHECK(NAME_ff(&params, &state, home, slow, zero, moving, &info) == UPPER_OK);
    CHECK(info.undetermined == 0 && info.reaction > 0 && info.joint >= 0 && info.steps > 0);
    CHECK(apart(moving, ideal) > 1e-3);
    /* Held: the friction of the last motion. Speed effects are about 1e-6. */
    CHECK(NAME_ff(&params, &state, home, zero, zero, held, &info) == UPPER_UNDETERMINED);
    CHECK(apart(moving, held) < 1e-4 * apart(moving, ideal));
    /* Zero. */
    params.rest = UPPER_ZERO;
    CHECK(NAME_ff(&params, &state, home, zero, zero, found, &info) == UPPER_UNDETERMINED);
    CHECK(apart(found, ideal) == 0);
    CHECK(NAME_ff(&params, &state, home, slow, zero, moving, &info) == UPPER_OK);
    /* Faded: after ten calls by the tenth power of the factor. */
    params.rest = UPPER_FADED;
    params.fade = 0.5;
    for (k = 0; k < 10; ++k) {
        CHECK(NAME_ff(&params, &state, home, zero, zero, found, &info) == UPPER_UNDETERMINED);
    }
    CHECK(fabs(apart(found, ideal) / apart(held, ideal) - pow(0.5, 10)) < 1e-6);
    /* The accelerations, or a given direction, decide first. */
    params.rest = UPPER_HELD;
    CHECK(NAME_ff_towards(&params, &state, home, zero, zero, up, found, &info) == UPPER_UNDETERMINED);
    CHECK(apart(found, held) < 1e-6 * apart(held, ideal));
    CHECK(NAME_ff_towards(&params, &state, home, zero, zero, down, other, &info) == UPPER_UNDETERMINED);
    CHECK(apart(found, other) > apart(found, ideal));
    CHECK(NAME_ff(&params, &state, home, zero, down, other, &info) == UPPER_UNDETERMINED);
    CHECK(NAME_ff(&params, &state, home, zero, up, found, &info) == UPPER_UNDETERMINED);
    CHECK(apart(found, other) > 1e-3);
}

/* Impossible inputs: codes, the last efforts, and a state that still works. */
static void refusals(void)
{
    NAME_params params;
    NAME_state state;
    NAME_info info;
    double q[COUNT], v[COUNT], a[COUNT], tau[DRIVES], last[DRIVES];
    int k;
    NAME_defaults(&params);
    state.ready = 0;
    CHECK(NAME_ff(&params, &state, home, zero, zero, tau, &info) == UPPER_NOT_READY);
    CHECK(finite_all(tau, DRIVES));
    CHECK(NAME_init(0, home) == UPPER_BAD_INPUT);
    CHECK(NAME_init(&state, 0) == UPPER_BAD_INPUT);
    for (k = 0; k < COUNT; ++k) {
        q[k] = home[k] + 1e9;
        v[k] = 0.1;
        a[k] = 0.2;
    }
    CHECK(NAME_init(&state, q) == UPPER_OPEN);
    CHECK(NAME_init(&state, home) == UPPER_OK);
    CHECK(NAME_ff(0, &state, home, v, a, last, 0) == UPPER_OK);
    CHECK(NAME_ff(0, &state, q, v, a, tau, &info) == UPPER_OPEN);
    CHECK(apart(tau, last) == 0 && info.fallback == 2);
    q[0] = NAN;
    CHECK(NAME_ff(0, &state, q, v, a, tau, &info) == UPPER_BAD_INPUT);
    CHECK(NAME_ff(0, &state, home, q, a, tau, &info) == UPPER_BAD_INPUT);
    CHECK(NAME_ff(0, &state, home, v, q, tau, &info) == UPPER_BAD_INPUT);
    CHECK(NAME_ff_towards(0, &state, home, v, a, q, tau, &info) == UPPER_BAD_INPUT);
    CHECK(NAME_ff(0, &state, 0, v, a, tau, &info) == UPPER_BAD_INPUT);
    CHECK(NAME_ff(0, &state, home, v, a, 0, &info) == UPPER_BAD_INPUT);
    CHECK(NAME_ff(0, 0, home, v, a, tau, &info) == UPPER_BAD_INPUT);
    CHECK(apart(tau, last) == 0);
    /* Friction without a solution: that without friction. */
    params.mu[0] = NAN;
    CHECK(NAME_ff(&params, &state, home, v, a, tau, &info) < UPPER_OK || finite_all(tau, DRIVES));
    params.mu[0] = 1e3;
    for (k = 0; k < (int)(sizeof params.mu / sizeof params.mu[0]); ++k) {
        params.mu[k] = 1e3;
    }
    CHECK(NAME_ff(&params, &state, home, v, a, tau, &info) == UPPER_FRICTIONLESS);
    CHECK(finite_all(tau, DRIVES) && info.fallback == 1);
    CHECK(NAME_ff(0, &state, home, v, a, tau, &info) == UPPER_OK);
    CHECK(apart(tau, last) < 1e-9);
}

/* Any inputs of any size: results and state stay finite, and the codes are known. */
static void anything(void)
{
    static const double odd[] = { 0, 1e-320, 1e-30, 1e-9, 1, 1e3, 1e20, 1e154, 1e300, INFINITY, NAN };
    const int odds = (int)(sizeof odd / sizeof odd[0]);
    NAME_params params;
    NAME_state state;
    NAME_info info;
    int codes[16] = { 0 };
    int round;
    CHECK(NAME_init(&state, home) == UPPER_OK);
    for (round = 0; round < 40000; ++round) {
        double values[3][COUNT], tau[DRIVES];
        int code, k;
        for (k = 0; k < COUNT; ++k) {
            values[0][k] = home[k] + 0.03 * uniform() * (round % 7 == 0 ? odd[(round / 7) % odds] : 1);
            values[1][k] = uniform() * (round % 5 == 0 ? odd[(round / 5 + k) % odds] : 1);
            values[2][k] = uniform() * (round % 3 == 0 ? odd[(round / 3 + k) % odds] : 1);
        }
        NAME_defaults(&params);
        if (round % 11 == 0) {
            params.mu[0] = odd[(round / 11) % odds] * uniform();
            params.rest_rate = odd[(round / 13) % odds];
            params.rest = round % 4;
        }
        code = NAME_ff(&params, &state, values[0], values[1], values[2], tau, &info);
        CHECK(code >= UPPER_NOT_READY && code <= UPPER_FRICTIONLESS);
        CHECK(finite_all(tau, DRIVES));
        CHECK(finite_all(state.tree, UPPER_TREE) && finite_all(state.direction, COUNT));
        CHECK(finite_all(&info.residual, 1) && finite_all(&info.determinant, 1));
        CHECK(finite_all(&info.coupling, 1) && finite_all(&info.reaction, 1));
        if (failures > 5) {
            printf("round %d, code %d\n", round, code);
            return;
        }
        ++codes[code - UPPER_NOT_READY];
    }
    /* Most of them are answered. */
    CHECK(codes[UPPER_OK - UPPER_NOT_READY] > 8000);
    CHECK(NAME_init(&state, home) == UPPER_OK);
}

int main(void)
{
    rest();
    refusals();
    anything();
    return failures > 0;
}
