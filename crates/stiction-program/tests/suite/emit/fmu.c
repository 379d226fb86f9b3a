/* Importer of an FMU, linked statically: reproduces test vectors with many instances at once, and
   checks states, parameters, phases and refusals. */
#include "DRIVER_SOURCE"

#include <math.h>
#include <stdio.h>

#define ROWS (int)(sizeof VECTORS / sizeof VECTORS[0])
#define INSTANCES 100

static const double VECTORS[][3 * COORDINATES + ACTUATORS] = {
VECTORS_HERE
};

static int complaints, reports;

static void check(int holds, const char *what)
{
    if (!holds) {
        printf("failed: %s\n", what);
        complaints += 1;
    }
}

#if VERSION == 2
typedef fmi2Component Handle;
typedef fmi2ValueReference Reference;
typedef fmi2FMUstate State;
static void logger(void *environment, const char *name, fmi2Status status, const char *category,
    const char *text, ...)
{
    (void)name, (void)status, (void)category, (void)text;
    reports += 1;
    check(environment == &complaints, "environment");
}
static Handle make_one(const char *token)
{
    static const fmi2CallbackFunctions CALLBACKS = { logger, 0, 0, 0, &complaints };
    return fmi2Instantiate("name", fmi2CoSimulation, token, "", &CALLBACKS, 0, 1);
}
static int begin(Handle h)
{
    return (int)fmi2SetupExperiment(h, 0, 0, 0, 0, 0) + (int)fmi2EnterInitializationMode(h);
}
#define leave(h) fmi2ExitInitializationMode(h)
#define finish(h) fmi2Terminate(h)
#define reset(h) fmi2Reset(h)
#define release(h) fmi2FreeInstance(h)
#define set(h, r, n, v) (int)fmi2SetReal(h, r, n, v)
#define get(h, r, n, v) (int)fmi2GetReal(h, r, n, v)
#define get_status(h, r, v) (int)fmi2GetInteger(h, r, 1, v)
#define do_step(h, t, s) (int)fmi2DoStep(h, t, s, 1)
#define keep(h, s) (int)fmi2GetFMUstate(h, s)
#define restore(h, s) (int)fmi2SetFMUstate(h, s)
#define forget(h, s) (int)fmi2FreeFMUstate(h, s)
#define size_of(h, s, n) (int)fmi2SerializedFMUstateSize(h, s, n)
#define to_bytes(h, s, b, n) (int)fmi2SerializeFMUstate(h, s, b, n)
#define from_bytes(h, b, n, s) (int)fmi2DeSerializeFMUstate(h, b, n, s)
#else
typedef fmi3Instance Handle;
typedef fmi3ValueReference Reference;
typedef fmi3FMUState State;
static void logger(void *environment, fmi3Status status, const char *category, const char *text)
{
    (void)status, (void)category, (void)text;
    reports += 1;
    check(environment == &complaints, "environment");
}
static Handle make_one(const char *token)
{
    return fmi3InstantiateCoSimulation("name", token, "", false, true, false, false, 0, 0,
        &complaints, logger, 0);
}
static int begin(Handle h)
{
    return (int)fmi3EnterInitializationMode(h, false, 0, 0, false, 0);
}
static int do_step(Handle h, double t, double s)
{
    bool a, b, c;
    double last = -1;
    const int status = fmi3DoStep(h, t, s, true, &a, &b, &c, &last);
    check(!a && !b && !c, "flags of a step");
    check(status > 1 || last == t + s, "time after a step");
    return status;
}
#define leave(h) fmi3ExitInitializationMode(h)
#define finish(h) fmi3Terminate(h)
#define reset(h) fmi3Reset(h)
#define release(h) fmi3FreeInstance(h)
#define set(h, r, n, v) (int)fmi3SetFloat64(h, r, n, v, n)
#define get(h, r, n, v) (int)fmi3GetFloat64(h, r, n, v, n)
#define get_status(h, r, v) (int)fmi3GetInt32(h, r, 1, v, 1)
#define keep(h, s) (int)fmi3GetFMUState(h, s)
#define restore(h, s) (int)fmi3SetFMUState(h, s)
#define forget(h, s) (int)fmi3FreeFMUState(h, s)
#define size_of(h, s, n) (int)fmi3SerializedFMUStateSize(h, s, n)
#define to_bytes(h, s, b, n) (int)fmi3SerializeFMUState(h, s, (fmi3Byte *)b, n)
#define from_bytes(h, b, n, s) (int)fmi3DeserializeFMUState(h, (fmi3Byte *)b, n, s)
#endif

static Reference inputs[3 * COORDINATES], efforts[ACTUATORS];

static void compare(Handle h, const double *row, const char *what)
{
    double tau[ACTUATORS], most = 0, apart = 0;
    int k;
    check(get(h, efforts, ACTUATORS, tau) == STATUS_OK, what);
    for (k = 0; k < ACTUATORS; ++k) {
        const double expected = row[3 * COORDINATES + k];
        most = fmax(most, fabs(expected));
        apart = fmax(apart, fabs(tau[k] - expected));
    }
    check(apart <= 1e-11 * most, what);
}

int main(void)
{
    static Handle all[INSTANCES];
    const Reference status = STATUS, mu = TUNABLES, wrong = VARIABLES;
    double nan[3 * COORDINATES] = { 0 }, before[ACTUATORS], tau[ACTUATORS], x;
    int k, n, code;
    State state = 0, copy = 0;
    size_t size = 0;
    char *bytes;
    for (k = 0; k < 3 * COORDINATES; ++k) {
        inputs[k] = INPUTS + (Reference)k;
    }
    for (k = 0; k < ACTUATORS; ++k) {
        efforts[k] = EFFORTS + (Reference)k;
    }
    check(make_one("{another}") == 0 && reports == 1, "another token");
    for (k = 0; k < INSTANCES; ++k) {
        all[k] = make_one("TOKEN");
        check(all[k] != 0 && begin(all[k]) == 0 && leave(all[k]) == 0, "initialisation");
    }
    /* Interleaved: each instance is at another row. */
    for (n = 0; n < ROWS; ++n) {
        for (k = 0; k < INSTANCES; ++k) {
            const double *row = VECTORS[(n + k) % ROWS];
            check(set(all[k], inputs, 3 * COORDINATES, row) == 0, "inputs");
            compare(all[k], row, "efforts follow the inputs of the same instant");
            check(do_step(all[k], 0.001 * n, 0.001) == 0, "step");
            compare(all[k], row, "efforts remain after a step");
        }
    }
    /* A parameter changes this instance only; the state contains it. */
    check(keep(all[0], &state) == 0 && size_of(all[0], state, &size) == 0, "state");
    check(get(all[0], efforts, ACTUATORS, before) == 0 && get(all[0], &mu, 1, &x) == 0, "get");
    x = 2 * x + 0.1;
    check(set(all[0], &mu, 1, &x) == 0 && get(all[0], efforts, ACTUATORS, tau) == 0, "parameter");
    check(memcmp(before, tau, sizeof tau) != 0, "a parameter changes efforts");
    compare(all[1], VECTORS[0], "another instance");
    bytes = (char *)malloc(size);
    check(to_bytes(all[0], state, bytes, size) == 0, "serialise");
    check(from_bytes(all[2], bytes, size, &copy) == 0 && restore(all[2], copy) == 0, "deserialise");
    check(get(all[2], efforts, ACTUATORS, tau) == 0 && memcmp(before, tau, sizeof tau) == 0,
        "a copied state gives the same efforts");
    bytes[0] = (char)(bytes[0] + 1);
    check(from_bytes(all[2], bytes, size, &copy) == STATUS_ERROR, "other bytes are no state");
    check(from_bytes(all[2], bytes, size - 1, &copy) == STATUS_ERROR, "too few bytes");
    check(restore(all[0], state) == 0 && get(all[0], efforts, ACTUATORS, tau) == 0
            && memcmp(before, tau, sizeof tau) == 0,
        "a restored state gives the same efforts");
    check(forget(all[0], &state) == 0 && state == 0 && forget(all[2], &copy) == 0, "free");
    free(bytes);
    /* Refusals: the efforts keep their last values, and are never NaN. */
    x = -1;
    check(set(all[0], &mu, 1, &x) == STATUS_ERROR, "a negative coefficient");
    check(set(all[0], &wrong, 1, &x) == STATUS_ERROR, "no such variable");
    check(get(all[0], &wrong, 1, &x) == STATUS_ERROR, "no such variable");
    check(set(all[0], efforts, 1, &x) == STATUS_ERROR, "an output");
    nan[COORDINATES] = NAN;
    check(set(all[0], inputs, 3 * COORDINATES, nan) == 0, "NaN");
    reports = 0;
    check(do_step(all[0], 1, 0.001) == STATUS_DISCARD && reports == 1, "NaN is discarded");
    check(get(all[0], efforts, ACTUATORS, tau) == STATUS_OK, "last efforts");
    check(get_status(all[0], &status, &code) == 0 && code == -1, "status of NaN");
    check(memcmp(before, tau, sizeof tau) == 0, "the last efforts remain");
    nan[COORDINATES] = 0;
    nan[0] = 1e9;
    check(set(all[0], inputs, 3 * COORDINATES, nan) == 0, "far away");
    check(get(all[0], efforts, ACTUATORS, tau) == STATUS_DISCARD, "out of reach");
    check(memcmp(before, tau, sizeof tau) == 0, "the last efforts remain");
    check(do_step(all[0], 1, -1) == STATUS_ERROR, "a negative step");
    check(finish(all[0]) == 0 && do_step(all[0], 1, 0.1) == STATUS_ERROR, "phases");
    check(reset(all[0]) == 0 && begin(all[0]) == 0 && leave(all[0]) == 0, "reset");
    for (k = 0; k < INSTANCES; ++k) {
        release(all[k]);
    }
    printf("%d rows, %d instances, %d complaints\n", ROWS, INSTANCES, complaints);
    return complaints != 0;
}
