/*
@LINES@ */

/* Feed-forward of @NAME@ as a functional mock-up unit (FMU) for co-simulation, FMI @FMI_VERSION@.

   All data belong to an instance, so instances are independent. The declarations of FMI follow the
   FMI specification @FMI_VERSION@ of the Modelica Association. Functions have the names of the
   specification; for static linking, define FMI@FMI@_FUNCTION_PREFIX as the beginning of their names. */

#include "@NAME@.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#ifdef __cplusplus
#define EXTERN_C extern "C"
#else
#define EXTERN_C
#endif
#define PASTE(a, b) a##b
#define EXPANDED(a, b) PASTE(a, b)
#if defined(FMI@FMI@_FUNCTION_PREFIX)
#define FULL(name) EXPANDED(FMI@FMI@_FUNCTION_PREFIX, name)
#define SHOWN EXTERN_C
#else
#define FULL(name) name
#if defined(_WIN32) || defined(__CYGWIN__)
#define SHOWN EXTERN_C __declspec(dllexport)
#elif defined(__GNUC__)
#define SHOWN EXTERN_C __attribute__((visibility("default")))
#else
#define SHOWN EXTERN_C
#endif
#endif

#define COORDINATES @GUARD@_COORDINATES
#define ACTUATORS @GUARD@_ACTUATORS

@TYPES@
/* Value references, in the order of modelDescription.xml. */
enum {
    TIME = 0,
    INPUTS = 1,
    EFFORTS = INPUTS + 3 * COORDINATES,
    RESIDUAL = EFFORTS + ACTUATORS,
    SINGULARITY_INDEX,
    DETERMINANT,
    COUPLING,
    REACTION,
    STATUS,
    REST,
    REST_RATE,
    FADE,
    TUNABLES,
    VARIABLES = TUNABLES + @TUNABLES@
};

/* Status, numbered as by FMI. */
enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR };

/* Phases of an instance. */
enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED };

/* Mark and length of a serialised state. */
#define MARK (0x46460001u ^ @GUARD@_FINGERPRINT_LOW)

/* Complete state of the FMU. */
typedef struct {
    @NAME@_params params;
    /* State at the last communication point, and state after the present inputs. */
    @NAME@_state last, now;
    @NAME@_info info;
    /* Positions, rates and accelerations. */
    double inputs[3 * COORDINATES];
    double tau[ACTUATORS];
    double time;
    int code;
    int phase;
    /* 1 if an input has changed since the efforts were computed. */
    int changed;
    /* 1 if `now` is the state after the inputs of this communication point. */
    int computed;
} Content;

typedef struct {
    Content content;
    void *environment;
    Logger logger;
    char *name;
    int logging;
} Instance;

static int worse(int a, int b)
{
    return a > b ? a : b;
}

/* Sends a message to the importer; defined with the functions of FMI. */
static void say(const Instance *instance, int status, const char *text);

static void set_home(Content *content)
{
    static const double HOME[COORDINATES] = {
@HOME_VALUES@
    };
    int k;
    memset(content, 0, sizeof *content);
    @NAME@_defaults(&content->params);
    for (k = 0; k < COORDINATES; ++k) {
        content->inputs[k] = HOME[k];
    }
    content->phase = INSTANTIATED;
    content->changed = 1;
}

static double *tunable(Content *content, unsigned reference)
{
    switch (reference) {
@PLACES@    default:
        return NULL;
    }
}

/* 1 if a parameter must not be negative. */
static int is_size(unsigned reference)
{
    switch (reference) {
@SIGNED@    default:
        return 1;
    }
}

static const char *meaning(int code)
{
    switch (code) {
    case @GUARD@_FRICTIONLESS:
        return "friction has no solution here: the efforts are those without friction";
    case @GUARD@_BAD_INPUT:
        return "an input is NaN or infinite: the efforts keep their last values";
    case @GUARD@_OPEN:
        return "the positions are out of reach: the efforts keep their last values";
    case @GUARD@_SINGULAR:
        return "the positions are singular: the efforts keep their last values";
    case @GUARD@_NOT_READY:
        return "the positions at the start are out of reach: there are no efforts";
    default:
        return "";
    }
}

static int status_of(int code)
{
    return code < 0 ? STATUS_DISCARD : code == @GUARD@_FRICTIONLESS ? STATUS_WARNING : STATUS_OK;
}

/* Computes the efforts for the present inputs from the state of the last communication point. */
static int compute(Instance *instance)
{
    Content *own = &instance->content;
    const double *q = own->inputs;
    const double *qd = q + COORDINATES;
    const double *qdd = qd + COORDINATES;
    if (own->changed || !own->computed) {
        @NAME@_state next = own->last;
        int code = @GUARD@_OK;
        if (next.ready == 0) {
            code = @NAME@_init(&next, q);
            code = code == @GUARD@_OPEN ? @GUARD@_NOT_READY : code;
        }
        if (code == @GUARD@_OK) {
            code = @NAME@_ff(&own->params, &next, q, qd, qdd, own->tau, &own->info);
            if (code == @GUARD@_OPEN) {
                /* A jump of the inputs is too far for one step: starts again from home and keeps the
                   state of the friction. */
                @NAME@_state walked = own->last;
                if (@NAME@_init(&walked, q) == @GUARD@_OK) {
                    memcpy(walked.tau, own->last.tau, sizeof walked.tau);
                    memcpy(walked.direction, own->last.direction, sizeof walked.direction);
                    walked.weight = own->last.weight;
                    next = walked;
                    code = @NAME@_ff(&own->params, &next, q, qd, qdd, own->tau, &own->info);
                }
            }
        }
        own->now = code < 0 ? own->last : next;
        own->code = code;
        own->changed = 0;
        own->computed = 1;
        if (status_of(code) != STATUS_OK) {
            say(instance, status_of(code), meaning(code));
        }
    }
    return status_of(own->code);
}

/* Ends a communication step. */
static int step(Instance *instance, double time, double size)
{
    Content *own = &instance->content;
    int status;
    if (own->phase != STEPPING) {
        say(instance, STATUS_ERROR, "a step needs an initialised instance");
        return STATUS_ERROR;
    }
    if (!(size > 0) || !(time - time == 0) || !(size - size == 0)) {
        say(instance, STATUS_ERROR, "a step needs a finite time and a positive finite size");
        return STATUS_ERROR;
    }
    status = compute(instance);
    if (status == STATUS_DISCARD) {
        return status;
    }
    own->last = own->now;
    own->computed = 0;
    own->time = time + size;
    return status;
}

static int get_real(Instance *instance, unsigned reference, double *value)
{
    Content *own = &instance->content;
    const double *place = tunable(own, reference);
    int status = STATUS_OK;
    if (reference == TIME) {
        *value = own->time;
        return STATUS_OK;
    }
    if (reference < EFFORTS) {
        *value = own->inputs[reference - INPUTS];
        return STATUS_OK;
    }
    if (place != NULL) {
        *value = *place;
        return STATUS_OK;
    }
    if (reference > REACTION) {
        say(instance, STATUS_ERROR, "there is no real variable of this value reference");
        return STATUS_ERROR;
    }
    /* Efforts are computed during initialisation; after a step they remain valid until an input changes. */
    if (own->phase == INITIALIZING || (own->phase == STEPPING && own->changed)) {
        status = compute(instance);
    }
    *value = reference == RESIDUAL       ? own->info.residual
        : reference == SINGULARITY_INDEX ? own->info.singularity_index
        : reference == DETERMINANT       ? own->info.determinant
        : reference == COUPLING          ? own->info.coupling
        : reference == REACTION          ? own->info.reaction
                                         : own->tau[reference - EFFORTS];
    return status;
}

static int set_real(Instance *instance, unsigned reference, double value)
{
    Content *own = &instance->content;
    double *place = reference >= INPUTS && reference < EFFORTS ? own->inputs + (reference - INPUTS)
                                                                : tunable(own, reference);
    if (place == NULL) {
        say(instance, STATUS_ERROR, "only inputs and parameters can be set");
        return STATUS_ERROR;
    }
    /* NaN or infinite inputs are detected when the efforts are computed. */
    if (reference >= EFFORTS && (!(value - value == 0) || (value < 0 && is_size(reference)))) {
        say(instance, STATUS_ERROR, "a parameter must be a finite number, and not negative");
        return STATUS_ERROR;
    }
    if (reference == FADE && value > 1) {
        say(instance, STATUS_ERROR, "the parameter friction.fade is at most 1");
        return STATUS_ERROR;
    }
    *place = value;
    own->changed = 1;
    return STATUS_OK;
}

static int get_integer(Instance *instance, unsigned reference, int *value)
{
    Content *own = &instance->content;
    if (reference == REST) {
        *value = own->params.rest;
        return STATUS_OK;
    }
    if (reference != STATUS) {
        say(instance, STATUS_ERROR, "there is no integer variable of this value reference");
        return STATUS_ERROR;
    }
    if (own->phase == INITIALIZING || (own->phase == STEPPING && own->changed)) {
        /* The status itself is always known. */
        (void)compute(instance);
    }
    *value = own->code;
    return STATUS_OK;
}

static int set_integer(Instance *instance, unsigned reference, int value)
{
    if (reference != REST || value < @GUARD@_HELD || value > @GUARD@_ZERO) {
        say(instance, STATUS_ERROR,
            "the only integer to set is friction.rest: 0 held, 1 faded, 2 zero");
        return STATUS_ERROR;
    }
    instance->content.params.rest = value;
    instance->content.changed = 1;
    return STATUS_OK;
}

/* Changes from one phase to another. */
static int go(Instance *instance, int from, int to)
{
    if (instance->content.phase != from) {
        say(instance, STATUS_ERROR, "this call is not possible in this phase of the instance");
        return STATUS_ERROR;
    }
    instance->content.phase = to;
    return STATUS_OK;
}

static int leave_initialization(Instance *instance)
{
    const int status = compute(instance);
    return status == STATUS_DISCARD ? STATUS_ERROR : worse(status, go(instance, INITIALIZING, STEPPING));
}

static Instance *make(const char *name, const char *token, const char *expected)
{
    Instance *instance;
    const size_t length = name != NULL ? strlen(name) : 0;
    if (token == NULL || strcmp(token, expected) != 0) {
        return NULL;
    }
    instance = (Instance *)calloc(1, sizeof *instance);
    if (instance == NULL) {
        return NULL;
    }
    instance->name = (char *)calloc(length + 1, 1);
    if (instance->name == NULL) {
        free(instance);
        return NULL;
    }
    if (length > 0) {
        memcpy(instance->name, name, length);
    }
    set_home(&instance->content);
    return instance;
}

static void drop(Instance *instance)
{
    if (instance != NULL) {
        free(instance->name);
        free(instance);
    }
}

/* Copies the state; allocates memory if the caller has none. */
static int get_state(const Instance *instance, void **state)
{
    if (state == NULL) {
        return STATUS_ERROR;
    }
    if (*state == NULL) {
        *state = malloc(sizeof(Content));
    }
    if (*state == NULL) {
        say(instance, STATUS_ERROR, "there is no memory for the state");
        return STATUS_ERROR;
    }
    memcpy(*state, &instance->content, sizeof(Content));
    return STATUS_OK;
}

static int set_state(Instance *instance, const void *state)
{
    if (state == NULL) {
        return STATUS_ERROR;
    }
    memcpy(&instance->content, state, sizeof(Content));
    return STATUS_OK;
}

#define SERIALIZED (sizeof(unsigned) + sizeof(Content))

static int serialize(const Instance *instance, const void *state, void *bytes, size_t size)
{
    const unsigned mark = MARK;
    if (state == NULL || bytes == NULL || size < SERIALIZED) {
        say(instance, STATUS_ERROR, "there is no state, or no room for it");
        return STATUS_ERROR;
    }
    memcpy(bytes, &mark, sizeof mark);
    memcpy((char *)bytes + sizeof mark, state, sizeof(Content));
    return STATUS_OK;
}

static int deserialize(const Instance *instance, const void *bytes, size_t size, void **state)
{
    unsigned mark = 0;
    if (bytes != NULL && size >= SERIALIZED) {
        memcpy(&mark, bytes, sizeof mark);
    }
    if (state == NULL || mark != MARK) {
        say(instance, STATUS_ERROR, "these bytes are not a state of this model");
        return STATUS_ERROR;
    }
    if (*state == NULL) {
        *state = malloc(sizeof(Content));
    }
    if (*state == NULL) {
        say(instance, STATUS_ERROR, "there is no memory for the state");
        return STATUS_ERROR;
    }
    memcpy(*state, (const char *)bytes + sizeof mark, sizeof(Content));
    return STATUS_OK;
}

