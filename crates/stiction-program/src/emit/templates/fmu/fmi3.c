#define FMI(result, name) SHOWN result FULL(name)

static void say(const Instance *instance, int status, const char *text)
{
    if (instance->logger != 0 && (instance->logging || status >= STATUS_ERROR)) {
        instance->logger(instance->environment, (fmi3Status)status,
            status >= STATUS_ERROR         ? "logStatusError"
                : status == STATUS_DISCARD ? "logStatusDiscard"
                                           : "logStatusWarning",
            text);
    }
}

static fmi3Status refuse(fmi3Instance instance, const char *text)
{
    if (instance != NULL) {
        say((Instance *)instance, STATUS_ERROR, text);
    }
    return fmi3Error;
}

FMI(const char *, fmi3GetVersion)(void)
{
    return "3.0";
}

FMI(fmi3Status, fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean on, size_t count,
    const fmi3String categories[])
{
    (void)count;
    (void)categories;
    if (instance == NULL) {
        return fmi3Error;
    }
    ((Instance *)instance)->logging = on;
    return fmi3OK;
}

FMI(fmi3Instance, fmi3InstantiateModelExchange)(fmi3String name, fmi3String token,
    fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    if (logger != 0) {
        logger(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation only");
    }
    return NULL;
}

FMI(fmi3Instance, fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token,
    fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)clock;
    (void)lock;
    (void)unlock;
    if (logger != 0) {
        logger(environment, fmi3Error, "logStatusError", "this FMU is for co-simulation only");
    }
    return NULL;
}

FMI(fmi3Instance, fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token,
    fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
    fmi3Boolean early_return, const fmi3ValueReference intermediate[], size_t count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3IntermediateUpdateCallback update)
{
    Instance *instance = make(name, token, "@TOKEN@");
    (void)resources;
    (void)visible;
    (void)event_mode;
    (void)early_return;
    (void)intermediate;
    (void)count;
    (void)update;
    if (instance == NULL) {
        if (logger != 0) {
            logger(environment, fmi3Error, "logStatusError",
                "no instance: another instantiation token, or no memory");
        }
        return NULL;
    }
    instance->environment = environment;
    instance->logger = logger;
    instance->logging = logging;
    return instance;
}

FMI(void, fmi3FreeInstance)(fmi3Instance instance)
{
    drop((Instance *)instance);
}

FMI(fmi3Status, fmi3EnterInitializationMode)(fmi3Instance instance, fmi3Boolean has_tolerance,
    fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop)
{
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    if (instance == NULL) {
        return fmi3Error;
    }
    ((Instance *)instance)->content.time = start;
    return (fmi3Status)go((Instance *)instance, INSTANTIATED, INITIALIZING);
}

FMI(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance instance)
{
    return instance == NULL ? fmi3Error
                            : (fmi3Status)leave_initialization((Instance *)instance);
}

FMI(fmi3Status, fmi3Terminate)(fmi3Instance instance)
{
    return instance == NULL ? fmi3Error
                            : (fmi3Status)go((Instance *)instance, STEPPING, TERMINATED);
}

FMI(fmi3Status, fmi3Reset)(fmi3Instance instance)
{
    if (instance == NULL) {
        return fmi3Error;
    }
    set_home(&((Instance *)instance)->content);
    return fmi3OK;
}

FMI(fmi3Status, fmi3DoStep)(fmi3Instance instance, fmi3Float64 time, fmi3Float64 size,
    fmi3Boolean final, fmi3Boolean *events, fmi3Boolean *terminate, fmi3Boolean *early_return,
    fmi3Float64 *last_time)
{
    int status;
    (void)final;
    if (instance == NULL) {
        return fmi3Error;
    }
    status = step((Instance *)instance, time, size);
    if (events != NULL) {
        *events = false;
    }
    if (terminate != NULL) {
        *terminate = false;
    }
    if (early_return != NULL) {
        *early_return = false;
    }
    if (last_time != NULL) {
        *last_time = ((Instance *)instance)->content.time;
    }
    return (fmi3Status)status;
}

FMI(fmi3Status, fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Float64 values[], size_t count)
{
    int status = STATUS_OK;
    size_t k;
    if (instance == NULL || count != reference_count) {
        return refuse(instance, "every variable has one value");
    }
    for (k = 0; k < count; ++k) {
        status = worse(status, get_real((Instance *)instance, references[k], values + k));
    }
    return (fmi3Status)status;
}

FMI(fmi3Status, fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Float64 values[], size_t count)
{
    int status = STATUS_OK;
    size_t k;
    if (instance == NULL || count != reference_count) {
        return refuse(instance, "every variable has one value");
    }
    for (k = 0; k < count; ++k) {
        status = worse(status, set_real((Instance *)instance, references[k], values[k]));
    }
    return (fmi3Status)status;
}

FMI(fmi3Status, fmi3GetInt32)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Int32 values[], size_t count)
{
    int status = STATUS_OK;
    size_t k;
    if (instance == NULL || count != reference_count) {
        return refuse(instance, "every variable has one value");
    }
    for (k = 0; k < count; ++k) {
        int value = 0;
        status = worse(status, get_integer((Instance *)instance, references[k], &value));
        values[k] = value;
    }
    return (fmi3Status)status;
}

FMI(fmi3Status, fmi3SetInt32)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Int32 values[], size_t count)
{
    int status = STATUS_OK;
    size_t k;
    if (instance == NULL || count != reference_count) {
        return refuse(instance, "every variable has one value");
    }
    for (k = 0; k < count; ++k) {
        status = worse(status, set_integer((Instance *)instance, references[k], (int)values[k]));
    }
    return (fmi3Status)status;
}
