/* A drive whose wheels follow their commands at once, until at step AT the fault FAULT shows. */

#include "wheel_drive.h"

#include <string.h>

void wheel_drive_reset(WheelDrive *drive) {
    memcpy(drive->value, START, sizeof START);
    drive->integral[0] = 0.0; /* counts the steps */
}

const char *wheel_drive_start(WheelDrive *drive) {
    (void)drive;
    return strcmp(FAULT, "start") == 0 ? "no battery found" : NULL;
}

const char *wheel_drive_step(WheelDrive *drive, double duration) {
    (void)duration;
    double *v = drive->value;
    v[LEFT_SPEED] = v[LEFT_COMMAND];
    v[RIGHT_SPEED] = v[RIGHT_COMMAND];
    v[LEFT_TORQUE] = v[RIGHT_TORQUE] = 1.0;
    if (drive->integral[0]++ < AT) return NULL;
    if (strcmp(FAULT, "crash") == 0) *(volatile int *)0 = 1;
    if (strcmp(FAULT, "nan") == 0) v[LEFT_SPEED] = 0.0 / (v[LEFT_SPEED] - v[LEFT_SPEED]);
    return strcmp(FAULT, "discard") == 0 ? "the solver gave up" : NULL;
}

int64_t wheel_drive_ticks(const WheelDrive *drive, int wheel) { return (int64_t)drive->integral[0] + wheel; }

Kind wheel_drive_kind(uint32_t reference) {
    if (reference < FIRST_INPUT) return TIME;
    if (reference < FIRST_PARAMETER) return INPUT;
    if (reference < FIRST_OUTPUT) return PARAMETER;
    return reference < REAL_COUNT ? OUTPUT : reference < VARIABLE_COUNT ? TICKS : UNKNOWN;
}
