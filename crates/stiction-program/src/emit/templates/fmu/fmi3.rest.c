/* Functions for types that no variable of the unit has. */
static const char NO_VARIABLES[] = "there are no variables of this type";

FMI(fmi3Status, fmi3GetFloat32)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Float32 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetFloat32)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Float32 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetInt8)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Int8 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetInt8)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Int8 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetUInt8)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3UInt8 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetUInt8)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3UInt8 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetInt16)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Int16 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetInt16)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Int16 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetUInt16)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3UInt16 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetUInt16)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3UInt16 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetUInt32)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3UInt32 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetUInt32)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3UInt32 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetInt64)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Int64 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetInt64)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Int64 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetUInt64)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3UInt64 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetUInt64)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3UInt64 values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetBoolean)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Boolean values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetBoolean)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Boolean values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetString)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3String values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetString)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3String values[], size_t count)
{
    (void)references;
    (void)values;
    return reference_count + count == 0 ? fmi3OK : refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetBinary)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, size_t sizes[], fmi3Binary values[], size_t count)
{
    (void)references;
    (void)reference_count;
    (void)sizes;
    (void)values;
    (void)count;
    return refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetBinary)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const size_t sizes[], const fmi3Binary values[], size_t count)
{
    (void)references;
    (void)reference_count;
    (void)sizes;
    (void)values;
    (void)count;
    return refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetClock)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Clock values[])
{
    (void)references;
    (void)reference_count;
    (void)values;
    return refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3SetClock)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Clock values[])
{
    (void)references;
    (void)reference_count;
    (void)values;
    return refuse(instance, NO_VARIABLES);
}

FMI(fmi3Status, fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    return instance == NULL ? fmi3Error : (fmi3Status)get_state((Instance *)instance, state);
}

FMI(fmi3Status, fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState state)
{
    return instance == NULL ? fmi3Error : (fmi3Status)set_state((Instance *)instance, state);
}

FMI(fmi3Status, fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    (void)instance;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMI(fmi3Status, fmi3SerializedFMUStateSize)(fmi3Instance instance, fmi3FMUState state,
    size_t *size)
{
    (void)state;
    if (instance == NULL || size == NULL) {
        return fmi3Error;
    }
    *size = SERIALIZED;
    return fmi3OK;
}

FMI(fmi3Status, fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState state,
    fmi3Byte bytes[], size_t size)
{
    return instance == NULL ? fmi3Error
                            : (fmi3Status)serialize((Instance *)instance, state, bytes, size);
}

FMI(fmi3Status, fmi3DeserializeFMUState)(fmi3Instance instance, const fmi3Byte bytes[],
    size_t size, fmi3FMUState *state)
{
    return instance == NULL ? fmi3Error
                            : (fmi3Status)deserialize((Instance *)instance, bytes, size, state);
}

/* Functions for capabilities that modelDescription.xml does not declare. */
static const char NOT_PROVIDED[] = "this function is not provided: see modelDescription.xml";

FMI(fmi3Status, fmi3GetNumberOfVariableDependencies)(fmi3Instance instance,
    fmi3ValueReference value_reference, size_t *count)
{
    (void)value_reference;
    (void)count;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetVariableDependencies)(fmi3Instance instance, fmi3ValueReference dependent,
    size_t element_indices_of_dependent[], fmi3ValueReference independents[],
    size_t element_indices_of_independents[], fmi3DependencyKind dependency_kinds[], size_t count)
{
    (void)dependent;
    (void)element_indices_of_dependent;
    (void)independents;
    (void)element_indices_of_independents;
    (void)dependency_kinds;
    (void)count;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetDirectionalDerivative)(fmi3Instance instance,
    const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[],
    size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 sensitivity[],
    size_t sensitivity_count)
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)seed_count;
    (void)sensitivity;
    (void)sensitivity_count;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetAdjointDerivative)(fmi3Instance instance,
    const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[],
    size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 sensitivity[],
    size_t sensitivity_count)
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)seed_count;
    (void)sensitivity;
    (void)sensitivity_count;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3EnterConfigurationMode)(fmi3Instance instance)
{
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3ExitConfigurationMode)(fmi3Instance instance)
{
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3EnterEventMode)(fmi3Instance instance)
{
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3EnterStepMode)(fmi3Instance instance)
{
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetIntervalDecimal)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, fmi3Float64 intervals[],
    fmi3IntervalQualifier qualifiers[])
{
    (void)references;
    (void)reference_count;
    (void)intervals;
    (void)qualifiers;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetIntervalFraction)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, fmi3UInt64 counters[],
    fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)references;
    (void)reference_count;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, fmi3Float64 shifts[])
{
    (void)references;
    (void)reference_count;
    (void)shifts;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetShiftFraction)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, fmi3UInt64 counters[],
    fmi3UInt64 resolutions[])
{
    (void)references;
    (void)reference_count;
    (void)counters;
    (void)resolutions;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3SetIntervalDecimal)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, const fmi3Float64 intervals[])
{
    (void)references;
    (void)reference_count;
    (void)intervals;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3SetIntervalFraction)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, const fmi3UInt64 counters[],
    const fmi3UInt64 resolutions[])
{
    (void)references;
    (void)reference_count;
    (void)counters;
    (void)resolutions;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3SetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference references[],
    size_t reference_count, const fmi3Float64 shifts[])
{
    (void)references;
    (void)reference_count;
    (void)shifts;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3SetShiftFraction)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, const fmi3UInt64 counters[],
    const fmi3UInt64 resolutions[])
{
    (void)references;
    (void)reference_count;
    (void)counters;
    (void)resolutions;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3EvaluateDiscreteStates)(fmi3Instance instance)
{
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3UpdateDiscreteStates)(fmi3Instance instance,
    fmi3Boolean *discrete_states_need_update, fmi3Boolean *terminate_simulation,
    fmi3Boolean *nominals_of_continuous_states_changed,
    fmi3Boolean *values_of_continuous_states_changed, fmi3Boolean *next_event_time_defined,
    fmi3Float64 *next_event_time)
{
    (void)discrete_states_need_update;
    (void)terminate_simulation;
    (void)nominals_of_continuous_states_changed;
    (void)values_of_continuous_states_changed;
    (void)next_event_time_defined;
    (void)next_event_time;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3EnterContinuousTimeMode)(fmi3Instance instance)
{
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3CompletedIntegratorStep)(fmi3Instance instance,
    fmi3Boolean no_set_state_prior_to_current_point, fmi3Boolean *enter_event_mode,
    fmi3Boolean *terminate_simulation)
{
    (void)no_set_state_prior_to_current_point;
    (void)enter_event_mode;
    (void)terminate_simulation;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3SetTime)(fmi3Instance instance, fmi3Float64 time)
{
    (void)time;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3SetContinuousStates)(fmi3Instance instance,
    const fmi3Float64 continuous_states[], size_t n_continuous_states)
{
    (void)continuous_states;
    (void)n_continuous_states;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetContinuousStateDerivatives)(fmi3Instance instance,
    fmi3Float64 derivatives[], size_t n_continuous_states)
{
    (void)derivatives;
    (void)n_continuous_states;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetEventIndicators)(fmi3Instance instance, fmi3Float64 event_indicators[],
    size_t n_event_indicators)
{
    (void)event_indicators;
    (void)n_event_indicators;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetContinuousStates)(fmi3Instance instance, fmi3Float64 continuous_states[],
    size_t n_continuous_states)
{
    (void)continuous_states;
    (void)n_continuous_states;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetNominalsOfContinuousStates)(fmi3Instance instance, fmi3Float64 nominals[],
    size_t n_continuous_states)
{
    (void)nominals;
    (void)n_continuous_states;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *n_event_indicators)
{
    (void)n_event_indicators;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetNumberOfContinuousStates)(fmi3Instance instance,
    size_t *n_continuous_states)
{
    (void)n_continuous_states;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3GetOutputDerivatives)(fmi3Instance instance,
    const fmi3ValueReference references[], size_t reference_count, const fmi3Int32 orders[],
    fmi3Float64 values[], size_t count)
{
    (void)references;
    (void)reference_count;
    (void)orders;
    (void)values;
    (void)count;
    return refuse(instance, NOT_PROVIDED);
}

FMI(fmi3Status, fmi3ActivateModelPartition)(fmi3Instance instance,
    fmi3ValueReference clock_reference, fmi3Float64 activation_time)
{
    (void)clock_reference;
    (void)activation_time;
    return refuse(instance, NOT_PROVIDED);
}
