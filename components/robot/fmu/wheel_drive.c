/* Two wheels on geared DC motors, a regulator and a battery: the same arithmetic in the same order as the native model.

   With the speeds w of the wheels, the currents i and the voltages u, k = torque_constant * gear_ratio, for each wheel:
       u = sat(k_p e + z),  dz/dt = k_i e + (k_i / k_p) (u - (k_p e + z)),  e = command - w
       L di/dt = u - R i - k w
       J dw/dt = k i - f,  |f| <= friction_torque, and a load that may resist but never drives
   Compile without contraction (-ffp-contract=off): then both agree to the last bit on most machines. */

#include "wheel_drive.h"

#include <math.h>
#include <string.h>

static double smaller(double a, double b) { return b < a ? b : a; }
static double greater(double a, double b) { return b > a ? b : a; }
static double clip(double x, double low, double high) { return smaller(greater(x, low), high); }

void wheel_drive_reset(WheelDrive *drive) {
    memcpy(drive->value, START, sizeof START);
    drive->value[BATTERY_VOLTAGE] = drive->value[OPEN_CIRCUIT_VOLTAGE];
    drive->integral[0] = drive->integral[1] = 0.0;
}

const char *wheel_drive_start(WheelDrive *drive) {
    double *v = drive->value;
    for (int reference = FIRST_PARAMETER; reference < FIRST_OUTPUT; reference++) {
        int may_be_zero = reference == BATTERY_RESISTANCE || reference == FRICTION_TORQUE ||
                          reference == ROTOR_INERTIA || reference == INDUCTANCE;
        if (!isfinite(v[reference]) || v[reference] < 0.0 || (v[reference] == 0.0 && !may_be_zero))
            return "a parameter is not a positive number";
    }
    if (!(4.0 * v[CURRENT_LIMIT] * v[BATTERY_RESISTANCE] < v[OPEN_CIRCUIT_VOLTAGE]))
        return "battery_resistance is too large to supply both motors";
    v[BATTERY_VOLTAGE] = v[OPEN_CIRCUIT_VOLTAGE];
    return NULL;
}

/* Speeds of the wheels once friction and loads have acted on them for `h` [s]. */
static void hold(double *v, double left, double right, double yielding, double coupling, double h) {
    double left_low = -h * (v[FRICTION_TORQUE] + greater(v[LEFT_LOAD], 0.0));
    double left_high = h * (v[FRICTION_TORQUE] + greater(-v[LEFT_LOAD], 0.0));
    double right_low = -h * (v[FRICTION_TORQUE] + greater(v[RIGHT_LOAD], 0.0));
    double right_high = h * (v[FRICTION_TORQUE] + greater(-v[RIGHT_LOAD], 0.0));
    double left_impulse = 0.0, right_impulse = 0.0;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double impulse = clip(left_impulse - left / yielding, left_low, left_high);
        left += yielding * (impulse - left_impulse);
        right += coupling * (impulse - left_impulse);
        left_impulse = impulse;
        impulse = clip(right_impulse - right / yielding, right_low, right_high);
        right += yielding * (impulse - right_impulse);
        left += coupling * (impulse - right_impulse);
        right_impulse = impulse;
    }
    if (left_low < left_impulse && left_impulse < left_high && right_low < right_impulse && right_impulse < right_high)
        left = right = 0.0; /* both are held: what the sweeps have left is not motion */
    v[LEFT_SPEED] = left;
    v[RIGHT_SPEED] = right;
}

static void inner_step(WheelDrive *drive, double h, double yielding, double coupling) {
    double *v = drive->value;
    double k = v[TORQUE_CONSTANT] * v[GEAR_RATIO];
    double power = 0.0;
    for (int j = 0; j < 2; j++) {
        double error = v[LEFT_COMMAND + j] - v[LEFT_SPEED + j];
        double wanted = v[PROPORTIONAL_GAIN] * error + drive->integral[j];
        double emf = k * v[LEFT_SPEED + j];
        double low = greater(-v[BATTERY_VOLTAGE], emf - v[RESISTANCE] * v[CURRENT_LIMIT]);
        double high = smaller(v[BATTERY_VOLTAGE], emf + v[RESISTANCE] * v[CURRENT_LIMIT]);
        double voltage = clip(wanted, low, high);
        drive->integral[j] +=
            h * (v[INTEGRAL_GAIN] * error + (v[INTEGRAL_GAIN] / v[PROPORTIONAL_GAIN]) * (voltage - wanted));
        double current =
            (v[INDUCTANCE] * v[LEFT_CURRENT + j] + h * (voltage - emf)) / (v[INDUCTANCE] + h * v[RESISTANCE]);
        v[LEFT_CURRENT + j] = current;
        v[LEFT_TORQUE + j] = k * current;
        power += voltage * current;
    }
    v[BATTERY_VOLTAGE] = v[OPEN_CIRCUIT_VOLTAGE] - v[BATTERY_RESISTANCE] * power / v[BATTERY_VOLTAGE];

    double before[2] = {v[LEFT_SPEED], v[RIGHT_SPEED]};
    hold(v, before[0] + h * (yielding * v[LEFT_TORQUE] + coupling * v[RIGHT_TORQUE]),
         before[1] + h * (coupling * v[LEFT_TORQUE] + yielding * v[RIGHT_TORQUE]), yielding, coupling, h);
    for (int j = 0; j < 2; j++) v[LEFT_ANGLE + j] += 0.5 * h * (before[j] + v[LEFT_SPEED + j]);
}

const char *wheel_drive_step(WheelDrive *drive, double duration) {
    double *v = drive->value;
    if (!(duration > 0.0) || !(duration <= 1e3)) return "the communication step is not a time from 0 to 1000 s";
    for (int reference = FIRST_INPUT; reference < FIRST_PARAMETER; reference++)
        if (!isfinite(v[reference])) return "an input is not a finite number";

    double many = duration / INNER_STEP - 1e-6;
    int steps = (int)many;
    if (steps < many) steps++;
    double h = duration / steps;
    double along = 0.25 * v[MASS] * v[WHEEL_RADIUS] * v[WHEEL_RADIUS];
    double about = v[YAW_INERTIA] * v[WHEEL_RADIUS] * v[WHEEL_RADIUS] / (v[TRACK] * v[TRACK]);
    double inertia = v[WHEEL_INERTIA] + v[ROTOR_INERTIA] * v[GEAR_RATIO] * v[GEAR_RATIO];
    double own = inertia + along + about;
    double cross = along - about;
    double determinant = own * own - cross * cross;
    for (int step = 0; step < steps; step++) inner_step(drive, h, own / determinant, -cross / determinant);
    return NULL;
}

int64_t wheel_drive_ticks(const WheelDrive *drive, int wheel) {
    double ticks = drive->value[LEFT_ANGLE + wheel] * (drive->value[TICKS_PER_TURN] / (2.0 * 3.141592653589793));
    int64_t whole = (int64_t)ticks;
    return whole > ticks ? whole - 1 : whole;
}

Kind wheel_drive_kind(uint32_t reference) {
    if (reference < FIRST_INPUT) return TIME;
    if (reference < FIRST_PARAMETER) return INPUT;
    if (reference < FIRST_OUTPUT) return PARAMETER;
    if (reference < REAL_COUNT) return OUTPUT;
    return reference < VARIABLE_COUNT ? TICKS : UNKNOWN;
}
