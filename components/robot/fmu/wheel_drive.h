/* Two wheels on geared DC motors: what fmi2.c and fmi3.c need to know of the model. */

#ifndef WHEEL_DRIVE_H
#define WHEEL_DRIVE_H

#include <stddef.h>
#include <stdint.h>

#include "variables.h"

typedef struct {
    double value[REAL_COUNT]; /* by value reference */
    double integral[2];       /* of the regulators, left first [V] */
} WheelDrive;

/* At rest, all variables at their start values. */
void wheel_drive_reset(WheelDrive *drive);

/* Apply the parameters. NULL, or what is wrong with them. */
const char *wheel_drive_start(WheelDrive *drive);

/* Let `duration` [s] pass. NULL, or why that cannot be. */
const char *wheel_drive_step(WheelDrive *drive, double duration);

/* What the encoder of a wheel (0 left, 1 right) has counted. */
int64_t wheel_drive_ticks(const WheelDrive *drive, int wheel);

/* How the variable of a value reference may be used. */
typedef enum { TIME, INPUT, PARAMETER, OUTPUT, TICKS, UNKNOWN } Kind;
Kind wheel_drive_kind(uint32_t reference);

#endif
