/* What an instance is, whatever the version of FMI: the model, where it is in its life, and whom to tell of errors. */

#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "wheel_drive.h"

typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED } Phase;

/* All that a stored state holds. */
typedef struct {
    WheelDrive drive;
    Phase phase;
} State;

typedef struct {
    State state;
    void *environment;
    void (*tell)(void *instance, const char *message); /* logs an error */
    void *log;
    char *name;
    char text[200];
} Instance;

/* Log that `function` fails, and why. */
static inline void complain(Instance *instance, const char *function, const char *why) {
    snprintf(instance->text, sizeof instance->text, "%s: %s", function, why);
    instance->tell(instance, instance->text);
}

/* Put real variables' values into `values`. NULL, or what is wrong. */
static inline const char *get_reals(const Instance *instance, const uint32_t *references, size_t count, double *values) {
    for (size_t n = 0; n < count; n++) {
        if (references[n] >= REAL_COUNT) return "there is no such real variable";
        values[n] = instance->state.drive.value[references[n]];
    }
    return NULL;
}

/* Set inputs, or before the first step parameters. NULL, or what is wrong. */
static inline const char *set_reals(Instance *instance, const uint32_t *references, size_t count, const double *values) {
    for (size_t n = 0; n < count; n++) {
        Kind kind = wheel_drive_kind(references[n]);
        if (kind == PARAMETER && instance->state.phase >= STEPPING)
            return "parameters are fixed once the initialization has ended";
        if (kind != PARAMETER && kind != INPUT) return "only inputs and parameters can be set";
        instance->state.drive.value[references[n]] = values[n];
    }
    return NULL;
}

/* Begin the steps. NULL, or what is wrong. */
static inline const char *start(Instance *instance) {
    if (instance->state.phase != INITIALIZING) return "the instance is not in its initialization";
    instance->state.phase = STEPPING;
    return wheel_drive_start(&instance->state.drive);
}

/* One communication step from `time` [s]. NULL, or what is wrong. */
static inline const char *advance(Instance *instance, double time, double duration) {
    if (instance->state.phase != STEPPING) return "the instance is not initialized";
    const char *problem = wheel_drive_step(&instance->state.drive, duration);
    if (!problem) instance->state.drive.value[NOW] = time + duration;
    return problem;
}

static inline Instance *new_instance(const char *name, void *environment, void (*tell)(void *, const char *)) {
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->name = malloc(strlen(name) + 1);
    if (!instance->name) {
        free(instance);
        return NULL;
    }
    strcpy(instance->name, name);
    instance->environment = environment;
    instance->tell = tell;
    wheel_drive_reset(&instance->state.drive);
    return instance;
}

static inline void reset(Instance *instance) {
    wheel_drive_reset(&instance->state.drive);
    instance->state.phase = INSTANTIATED;
}

static inline void free_instance(Instance *instance) {
    if (!instance) return;
    free(instance->name);
    free(instance);
}

/* Copy the state into `*stored`, which is made if it is NULL; false without memory. */
static inline bool store(const Instance *instance, void **stored) {
    if (!*stored) *stored = malloc(sizeof(State));
    if (*stored) memcpy(*stored, &instance->state, sizeof(State));
    return *stored != NULL;
}

#endif
