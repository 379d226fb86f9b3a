#define FMI(result, name) SHOWN result FULL(name)

static void say(const Instance *instance, int status, const char *text)
{
    if (instance->logger != 0 && (instance->logging || status >= STATUS_ERROR)) {
        instance->logger(instance->environment, instance->name, (fmi2Status)status,
            status >= STATUS_ERROR         ? "logStatusError"
                : status == STATUS_DISCARD ? "logStatusDiscard"
                                           : "logStatusWarning",
            "%s", text);
    }
}

static fmi2Status refuse(fmi2Component c, const char *text)
{
    if (c != NULL) {
        say((Instance *)c, STATUS_ERROR, text);
    }
    return fmi2Error;
}

FMI(const char *, fmi2GetTypesPlatform)(void)
{
    return "default";
}

FMI(const char *, fmi2GetVersion)(void)
{
    return "2.0";
}

FMI(fmi2Status, fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count,
    const fmi2String categories[])
{
    (void)count;
    (void)categories;
    if (c == NULL) {
        return fmi2Error;
    }
    ((Instance *)c)->logging = on != 0;
    return fmi2OK;
}

FMI(fmi2Component, fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid,
    fmi2String resources, const fmi2CallbackFunctions *functions, fmi2Boolean visible,
    fmi2Boolean logging)
{
    Instance *instance = type == fmi2CoSimulation ? make(name, guid, "@TOKEN@") : NULL;
    (void)resources;
    (void)visible;
    if (instance == NULL) {
        if (functions != NULL && functions->logger != 0) {
            functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError",
                "%s", "no instance: another type than co-simulation, another GUID, or no memory");
        }
        return NULL;
    }
    if (functions != NULL) {
        instance->logger = functions->logger;
        instance->environment = functions->componentEnvironment;
    }
    instance->logging = logging != 0;
    return instance;
}

FMI(void, fmi2FreeInstance)(fmi2Component c)
{
    drop((Instance *)c);
}

FMI(fmi2Status, fmi2SetupExperiment)(fmi2Component c, fmi2Boolean has_tolerance,
    fmi2Real tolerance, fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    if (c == NULL) {
        return fmi2Error;
    }
    ((Instance *)c)->content.time = start;
    return fmi2OK;
}

FMI(fmi2Status, fmi2EnterInitializationMode)(fmi2Component c)
{
    return c == NULL ? fmi2Error : (fmi2Status)go((Instance *)c, INSTANTIATED, INITIALIZING);
}

FMI(fmi2Status, fmi2ExitInitializationMode)(fmi2Component c)
{
    return c == NULL ? fmi2Error : (fmi2Status)leave_initialization((Instance *)c);
}

FMI(fmi2Status, fmi2Terminate)(fmi2Component c)
{
    return c == NULL ? fmi2Error : (fmi2Status)go((Instance *)c, STEPPING, TERMINATED);
}

FMI(fmi2Status, fmi2Reset)(fmi2Component c)
{
    if (c == NULL) {
        return fmi2Error;
    }
    set_home(&((Instance *)c)->content);
    return fmi2OK;
}

FMI(fmi2Status, fmi2GetReal)(fmi2Component c, const fmi2ValueReference references[], size_t count,
    fmi2Real values[])
{
    int status = STATUS_OK;
    size_t k;
    for (k = 0; c != NULL && k < count; ++k) {
        status = worse(status, get_real((Instance *)c, references[k], values + k));
    }
    return c == NULL ? fmi2Error : (fmi2Status)status;
}

FMI(fmi2Status, fmi2SetReal)(fmi2Component c, const fmi2ValueReference references[], size_t count,
    const fmi2Real values[])
{
    int status = STATUS_OK;
    size_t k;
    for (k = 0; c != NULL && k < count; ++k) {
        status = worse(status, set_real((Instance *)c, references[k], values[k]));
    }
    return c == NULL ? fmi2Error : (fmi2Status)status;
}

FMI(fmi2Status, fmi2GetInteger)(fmi2Component c, const fmi2ValueReference references[],
    size_t count, fmi2Integer values[])
{
    int status = STATUS_OK;
    size_t k;
    for (k = 0; c != NULL && k < count; ++k) {
        status = worse(status, get_integer((Instance *)c, references[k], values + k));
    }
    return c == NULL ? fmi2Error : (fmi2Status)status;
}

FMI(fmi2Status, fmi2SetInteger)(fmi2Component c, const fmi2ValueReference references[],
    size_t count, const fmi2Integer values[])
{
    int status = STATUS_OK;
    size_t k;
    for (k = 0; c != NULL && k < count; ++k) {
        status = worse(status, set_integer((Instance *)c, references[k], values[k]));
    }
    return c == NULL ? fmi2Error : (fmi2Status)status;
}

/* Functions for types that no variable of the unit has. */
FMI(fmi2Status, fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference references[],
    size_t count, fmi2Boolean values[])
{
    (void)references;
    (void)values;
    return count == 0 ? fmi2OK : refuse(c, "there are no Boolean variables");
}

FMI(fmi2Status, fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference references[],
    size_t count, const fmi2Boolean values[])
{
    (void)references;
    (void)values;
    return count == 0 ? fmi2OK : refuse(c, "there are no Boolean variables");
}

FMI(fmi2Status, fmi2GetString)(fmi2Component c, const fmi2ValueReference references[],
    size_t count, fmi2String values[])
{
    (void)references;
    (void)values;
    return count == 0 ? fmi2OK : refuse(c, "there are no string variables");
}

FMI(fmi2Status, fmi2SetString)(fmi2Component c, const fmi2ValueReference references[],
    size_t count, const fmi2String values[])
{
    (void)references;
    (void)values;
    return count == 0 ? fmi2OK : refuse(c, "there are no string variables");
}

FMI(fmi2Status, fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    return c == NULL ? fmi2Error : (fmi2Status)get_state((Instance *)c, state);
}

FMI(fmi2Status, fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    return c == NULL ? fmi2Error : (fmi2Status)set_state((Instance *)c, state);
}

FMI(fmi2Status, fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

FMI(fmi2Status, fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)state;
    if (c == NULL || size == NULL) {
        return fmi2Error;
    }
    *size = SERIALIZED;
    return fmi2OK;
}

FMI(fmi2Status, fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
    size_t size)
{
    return c == NULL ? fmi2Error : (fmi2Status)serialize((Instance *)c, state, bytes, size);
}

FMI(fmi2Status, fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size,
    fmi2FMUstate *state)
{
    return c == NULL ? fmi2Error : (fmi2Status)deserialize((Instance *)c, bytes, size, state);
}

FMI(fmi2Status, fmi2GetDirectionalDerivative)(fmi2Component c,
    const fmi2ValueReference unknowns[], size_t unknown_count, const fmi2ValueReference knowns[],
    size_t known_count, const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)sensitivity;
    return refuse(c, "directional derivatives are not provided");
}

FMI(fmi2Status, fmi2SetRealInputDerivatives)(fmi2Component c,
    const fmi2ValueReference references[], size_t count, const fmi2Integer orders[],
    const fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    return refuse(c, "derivatives of inputs are inputs of their own");
}

FMI(fmi2Status, fmi2GetRealOutputDerivatives)(fmi2Component c,
    const fmi2ValueReference references[], size_t count, const fmi2Integer orders[],
    fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    return refuse(c, "derivatives of outputs are not provided");
}

FMI(fmi2Status, fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean final)
{
    (void)final;
    return c == NULL ? fmi2Error : (fmi2Status)step((Instance *)c, time, size);
}

FMI(fmi2Status, fmi2CancelStep)(fmi2Component c)
{
    return refuse(c, "steps are complete when they return");
}

FMI(fmi2Status, fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

FMI(fmi2Status, fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (c == NULL || value == NULL || kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = ((Instance *)c)->content.time;
    return fmi2OK;
}

FMI(fmi2Status, fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind,
    fmi2Integer *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

FMI(fmi2Status, fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind,
    fmi2Boolean *value)
{
    if (c == NULL || value == NULL || kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = 0;
    return fmi2OK;
}

FMI(fmi2Status, fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind,
    fmi2String *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}
