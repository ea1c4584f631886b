/* The wheel drive as an FMI 3.0 co-simulation FMU. Every function of the standard is there; those that the model
   description does not offer return an error. */

#include "fmi3Functions.h"

#include "instance.h"

static void tell(void *instance, const char *message) {
    Instance *i = instance;
    union { void *object; fmi3LogMessageCallback function; } log = {i->log};
    if (log.function) log.function(i->environment, fmi3Error, "error", message);
}

static fmi3Status checked(void *instance, const char *function, const char *problem, fmi3Status failure) {
    if (!problem) return fmi3OK;
    complain(instance, function, problem);
    return failure;
}

static fmi3Status refuse(void *instance, const char *function) {
    return checked(instance, function, "this FMU does not offer it", fmi3Error);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    (void)instance, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)n, (void)update;
    if (strcmp(token, TOKEN) != 0) {
        if (log) log(environment, fmi3Error, "error", "the instantiation token is not that of this binary");
        return NULL;
    }
    Instance *instance = new_instance(name, environment, tell);
    union { fmi3LogMessageCallback function; void *object; } callback = {log};
    if (instance) instance->log = callback.object;
    return instance;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    if (log) log(environment, fmi3Error, "error", "this FMU is for co-simulation only");
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)clock, (void)lock, (void)unlock;
    return fmi3InstantiateModelExchange(name, token, resources, visible, logging, environment, log);
}

void fmi3FreeInstance(fmi3Instance instance) { free_instance(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 begin, fmi3Boolean has_end, fmi3Float64 end) {
    (void)has_tolerance, (void)tolerance, (void)has_end, (void)end;
    Instance *i = instance;
    if (i->state.phase != INSTANTIATED)
        return checked(i, __func__, "the instance is already initialized", fmi3Error);
    i->state.phase = INITIALIZING;
    i->state.drive.value[NOW] = begin;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return checked(instance, __func__, start(instance), fmi3Error);
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    ((Instance *)instance)->state.phase = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    reset(instance);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 duration, fmi3Boolean final,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)final;
    *event = *terminate = *early = false;
    const char *problem = advance(instance, time, duration);
    *reached = problem ? time : time + duration;
    return checked(instance, __func__, problem, fmi3Discard);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n, fmi3Float64 values[],
                          size_t count) {
    (void)count;
    return checked(instance, __func__, get_reals(instance, references, n, values), fmi3Error);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                          const fmi3Float64 values[], size_t count) {
    (void)count;
    return checked(instance, __func__, set_reals(instance, references, n, values), fmi3Error);
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t n, fmi3Int64 values[],
                        size_t count) {
    (void)count;
    Instance *i = instance;
    for (size_t k = 0; k < n; k++) {
        if (wheel_drive_kind(references[k]) != TICKS)
            return checked(i, __func__, "there is no such Int64 variable", fmi3Error);
        values[k] = wheel_drive_ticks(&i->state.drive, (int)(references[k] - LEFT_TICKS));
    }
    return fmi3OK;
}

/* Types that no variable has. */
#define NO_VARIABLES(TYPE)                                                                                             \
    fmi3Status fmi3Get##TYPE(fmi3Instance instance, const fmi3ValueReference references[], size_t n,                   \
                             fmi3##TYPE values[], size_t count) {                                                      \
        (void)references, (void)values, (void)count;                                                                   \
        return n ? refuse(instance, __func__) : fmi3OK;                                                                \
    }                                                                                                                  \
    NO_INPUTS(TYPE)
#define NO_INPUTS(TYPE)                                                                                                \
    fmi3Status fmi3Set##TYPE(fmi3Instance instance, const fmi3ValueReference references[], size_t n,                   \
                             const fmi3##TYPE values[], size_t count) {                                                \
        (void)references, (void)values, (void)count;                                                                   \
        return n ? refuse(instance, __func__) : fmi3OK;                                                                \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_INPUTS(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n, size_t sizes[],
                         fmi3Binary values[], size_t count) {
    (void)references, (void)sizes, (void)values, (void)count;
    return n ? refuse(instance, __func__) : fmi3OK;
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference references[], size_t n, const size_t sizes[],
                         const fmi3Binary values[], size_t count) {
    (void)references, (void)sizes, (void)values, (void)count;
    return n ? refuse(instance, __func__) : fmi3OK;
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t n, fmi3Clock values[]) {
    (void)references, (void)values;
    return n ? refuse(instance, __func__) : fmi3OK;
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                        const fmi3Clock values[]) {
    (void)references, (void)values;
    return n ? refuse(instance, __func__) : fmi3OK;
}

/* The state of an instance: stored, restored, and as bytes. */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    return checked(instance, __func__, store(instance, state) ? NULL : "out of memory", fmi3Error);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    memcpy(&((Instance *)instance)->state, state, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    (void)instance;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    (void)instance, (void)state;
    *size = sizeof(State);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    if (size < sizeof(State)) return checked(instance, __func__, "the buffer is too small", fmi3Error);
    memcpy(bytes, state, sizeof(State));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    if (size != sizeof(State)) return checked(instance, __func__, "these are not the bytes of a state", fmi3Error);
    if (!store(instance, state)) return checked(instance, __func__, "out of memory", fmi3Error);
    memcpy(*state, bytes, sizeof(State));
    return fmi3OK;
}

/* What the model description does not offer. */
#define REFUSED(NAME, ...)                                                                                             \
    fmi3Status NAME(fmi3Instance instance, __VA_ARGS__) { return refuse(instance, __func__); }
#define REFUSED_PLAIN(NAME)                                                                                            \
    fmi3Status NAME(fmi3Instance instance) { return refuse(instance, __func__); }

#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

REFUSED_PLAIN(fmi3EnterEventMode)
REFUSED_PLAIN(fmi3EnterConfigurationMode)
REFUSED_PLAIN(fmi3ExitConfigurationMode)
REFUSED_PLAIN(fmi3EvaluateDiscreteStates)
REFUSED_PLAIN(fmi3EnterContinuousTimeMode)
REFUSED_PLAIN(fmi3EnterStepMode)
REFUSED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference reference, size_t *n)
REFUSED(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
        size_t independent_elements[], fmi3DependencyKind kinds[], size_t n)
REFUSED(fmi3GetDirectionalDerivative, const fmi3ValueReference unknowns[], size_t n_unknowns,
        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
        fmi3Float64 sensitivity[], size_t n_sensitivity)
REFUSED(fmi3GetAdjointDerivative, const fmi3ValueReference unknowns[], size_t n_unknowns,
        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
        fmi3Float64 sensitivity[], size_t n_sensitivity)
REFUSED(fmi3GetIntervalDecimal, const fmi3ValueReference references[], size_t n, fmi3Float64 intervals[],
        fmi3IntervalQualifier qualifiers[])
REFUSED(fmi3GetIntervalFraction, const fmi3ValueReference references[], size_t n, fmi3UInt64 counters[],
        fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
REFUSED(fmi3GetShiftDecimal, const fmi3ValueReference references[], size_t n, fmi3Float64 shifts[])
REFUSED(fmi3GetShiftFraction, const fmi3ValueReference references[], size_t n, fmi3UInt64 counters[],
        fmi3UInt64 resolutions[])
REFUSED(fmi3SetIntervalDecimal, const fmi3ValueReference references[], size_t n, const fmi3Float64 intervals[])
REFUSED(fmi3SetIntervalFraction, const fmi3ValueReference references[], size_t n, const fmi3UInt64 counters[],
        const fmi3UInt64 resolutions[])
REFUSED(fmi3SetShiftDecimal, const fmi3ValueReference references[], size_t n, const fmi3Float64 shifts[])
REFUSED(fmi3SetShiftFraction, const fmi3ValueReference references[], size_t n, const fmi3UInt64 counters[],
        const fmi3UInt64 resolutions[])
REFUSED(fmi3UpdateDiscreteStates, fmi3Boolean *need_update, fmi3Boolean *terminate, fmi3Boolean *nominals,
        fmi3Boolean *values, fmi3Boolean *event_defined, fmi3Float64 *event)
REFUSED(fmi3CompletedIntegratorStep, fmi3Boolean final, fmi3Boolean *event, fmi3Boolean *terminate)
REFUSED(fmi3SetTime, fmi3Float64 time)
REFUSED(fmi3SetContinuousStates, const fmi3Float64 states[], size_t n)
REFUSED(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t n)
REFUSED(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t n)
REFUSED(fmi3GetContinuousStates, fmi3Float64 states[], size_t n)
REFUSED(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
REFUSED(fmi3GetNumberOfEventIndicators, size_t *n)
REFUSED(fmi3GetNumberOfContinuousStates, size_t *n)
REFUSED(fmi3GetOutputDerivatives, const fmi3ValueReference references[], size_t n, const fmi3Int32 orders[],
        fmi3Float64 values[], size_t count)
REFUSED(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
