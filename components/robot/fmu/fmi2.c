/* The wheel drive as an FMI 2.0 co-simulation FMU. Every function of the standard is there; those that the model
   description does not offer return an error. */

#include "fmi2Functions.h"

#include "instance.h"

static void tell(void *instance, const char *message) {
    Instance *i = instance;
    const fmi2CallbackFunctions *callbacks = i->log;
    if (callbacks->logger)
        callbacks->logger(callbacks->componentEnvironment, i->name, fmi2Error, "error", "%s", message);
}

static fmi2Status checked(void *instance, const char *function, const char *problem, fmi2Status failure) {
    if (!problem) return fmi2OK;
    complain(instance, function, problem);
    return failure;
}

static fmi2Status refuse(void *instance, const char *function) {
    return checked(instance, function, "this FMU does not offer it", fmi2Error);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources, (void)visible, (void)logging;
    const char *problem = strcmp(guid, TOKEN) != 0   ? "the GUID is not that of this binary"
                          : type != fmi2CoSimulation ? "this FMU is for co-simulation only"
                                                     : NULL;
    if (problem) {
        if (callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "error", "%s", problem);
        return NULL;
    }
    Instance *instance = new_instance(name, callbacks->componentEnvironment, tell);
    if (instance) instance->log = (void *)callbacks;
    return instance;
}

void fmi2FreeInstance(fmi2Component c) { free_instance(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real begin,
                               fmi2Boolean has_end, fmi2Real end) {
    (void)has_tolerance, (void)tolerance, (void)has_end, (void)end;
    ((Instance *)c)->state.drive.value[NOW] = begin;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *i = c;
    if (i->state.phase != INSTANTIATED)
        return checked(i, __func__, "the instance is already initialized", fmi2Error);
    i->state.phase = INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return checked(c, __func__, start(c), fmi2Error); }

fmi2Status fmi2Terminate(fmi2Component c) {
    ((Instance *)c)->state.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    reset(c);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real duration, fmi2Boolean final) {
    (void)final;
    return checked(c, __func__, advance(c, time, duration), fmi2Discard);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n, fmi2Real values[]) {
    return checked(c, __func__, get_reals(c, references, n, values), fmi2Error);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n, const fmi2Real values[]) {
    return checked(c, __func__, set_reals(c, references, n, values), fmi2Error);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t n, fmi2Integer values[]) {
    Instance *i = c;
    for (size_t k = 0; k < n; k++) {
        if (wheel_drive_kind(references[k]) != TICKS)
            return checked(i, __func__, "there is no such integer variable", fmi2Error);
        values[k] = (fmi2Integer)wheel_drive_ticks(&i->state.drive, (int)(references[k] - LEFT_TICKS));
    }
    return fmi2OK;
}

/* The state of an instance: stored, restored, and as bytes. */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    return checked(c, __func__, store(c, state) ? NULL : "out of memory", fmi2Error);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(&((Instance *)c)->state, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(State);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (size < sizeof(State)) return checked(c, __func__, "the buffer is too small", fmi2Error);
    memcpy(bytes, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    if (size != sizeof(State)) return checked(c, __func__, "these are not the bytes of a state", fmi2Error);
    if (!store(c, state)) return checked(c, __func__, "out of memory", fmi2Error);
    memcpy(*state, bytes, sizeof(State));
    return fmi2OK;
}

/* What the model description does not offer. */
#define REFUSED(NAME, ...)                                                                                             \
    fmi2Status NAME(fmi2Component c, __VA_ARGS__) { return refuse(c, __func__); }
#define NO_VARIABLES(TYPE)                                                                                             \
    fmi2Status fmi2Get##TYPE(fmi2Component c, const fmi2ValueReference references[], size_t n, fmi2##TYPE values[]) {  \
        return n ? refuse(c, __func__) : fmi2OK;                                                                       \
    }                                                                                                                  \
    NO_INPUTS(TYPE)
#define NO_INPUTS(TYPE)                                                                                                \
    fmi2Status fmi2Set##TYPE(fmi2Component c, const fmi2ValueReference references[], size_t n,                         \
                             const fmi2##TYPE values[]) {                                                              \
        return n ? refuse(c, __func__) : fmi2OK;                                                                       \
    }

#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

NO_INPUTS(Integer)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)
fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(c, __func__); }
fmi2Status fmi2EnterEventMode(fmi2Component c) { return refuse(c, __func__); }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return refuse(c, __func__); }
REFUSED(fmi2GetDirectionalDerivative, const fmi2ValueReference unknowns[], size_t n_unknowns,
        const fmi2ValueReference knowns[], size_t n_knowns, const fmi2Real seed[], fmi2Real sensitivity[])
REFUSED(fmi2SetRealInputDerivatives, const fmi2ValueReference references[], size_t n, const fmi2Integer orders[],
        const fmi2Real values[])
REFUSED(fmi2GetRealOutputDerivatives, const fmi2ValueReference references[], size_t n, const fmi2Integer orders[],
        fmi2Real values[])
REFUSED(fmi2GetStatus, const fmi2StatusKind kind, fmi2Status *value)
REFUSED(fmi2GetRealStatus, const fmi2StatusKind kind, fmi2Real *value)
REFUSED(fmi2GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *value)
REFUSED(fmi2GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSED(fmi2GetStringStatus, const fmi2StatusKind kind, fmi2String *value)
REFUSED(fmi2NewDiscreteStates, fmi2EventInfo *info)
REFUSED(fmi2CompletedIntegratorStep, fmi2Boolean final, fmi2Boolean *event, fmi2Boolean *terminate)
REFUSED(fmi2SetTime, fmi2Real time)
REFUSED(fmi2SetContinuousStates, const fmi2Real states[], size_t n)
REFUSED(fmi2GetDerivatives, fmi2Real derivatives[], size_t n)
REFUSED(fmi2GetEventIndicators, fmi2Real indicators[], size_t n)
REFUSED(fmi2GetContinuousStates, fmi2Real states[], size_t n)
REFUSED(fmi2GetNominalsOfContinuousStates, fmi2Real nominals[], size_t n)
