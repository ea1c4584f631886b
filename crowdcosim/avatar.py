"""The walking human body: a person's state -> 17 capsules, for sensors, contacts and viewers alike.

Each foot follows X(phi), where it would stand flat, seen from the body. With the stride L and the duty d of
`crowdcosim.gait`, the left foot at phi, the right one half a cycle later:
    stance, phi < d:  X = L (d / 2 - c - phi): at rest on the floor under a body that moves on at L per cycle;
    swing:            X is a cubic Hermite curve back to the front that leaves and arrives as the stance does.
It turns about its heel when it lands and about its ball when it pushes off: both are spheres that stay where they are.
The hips are as high as the legs reach (a soft minimum) and as the walk lets them, and knees follow by two-link inverse
kinematics. Arms, the pelvis and the sway follow Boulic, Magnenat-Thalmann and Thalmann 1990, "A global human walking
model with real-time kinematic personification", with nu = v / h:
    shoulder  3 - a / 2 - a cos 2 pi phi [deg], a = 9.88 nu;     pelvis   -4 nu cos 2 pi phi [deg] about the vertical;
    sideways  0.032 sin 2 pi (phi - 0.1) h, less below nu = 0.5; upwards  0.015 nu (sin 2 pi (2 phi - 0.35) - 1) h.

Differs from the paper: its leg angles let the feet slide; here the feet stand still. The elbow's 6 to 20 degrees are a
cosine. Not in the paper: how the feet roll, their track and how high they swing, the shoulders' turn against the
pelvis, the trunk's lean, and steps to the side or backwards, in which the feet do not roll. Nobody runs: beyond
nu = 2.6 / s (2.4 m/s for an average adult; 1 / s aside or back) the feet slide. They do so a little, too, while
somebody accelerates or turns, as the state of a person does not tell how fast they do that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdcosim import body
from crowdcosim.gait import HIP, cycle_time, duty

Array = NDArray[np.float64]

REACH = 0.5
"""no part of a body is farther than this from the person's position, over stature, as seen from above"""

CAPSULES = len(body.SEGMENTS)
LEGS = 6
"""the first capsules: feet, shanks and thighs"""
LEGS_ONLY = 0.2
"""no other part of a body is lower than this, over stature"""
_RADII = tuple(body.RADIUS.tolist())
_FOOT, _SHANK, _THIGH, _PELVIS, _TRUNK, _NECK, _HEAD, _UPPER_ARM, _FOREARM, _HAND = (
    next(i for i, segment in enumerate(body.SEGMENTS) if segment.endswith(name))
    for name in ("foot", "shank", "thigh", "pelvis", "trunk", "neck", "head", "upper arm", "forearm", "hand")
)

# All lengths here are fractions of the stature, all angles radians, all phases cycles.
_DEGREE = math.pi / 180.0
_THIGH_LENGTH, _SHANK_LENGTH = body.THIGH, body.SHANK
_UPPER_ARM_LENGTH, _FOREARM_LENGTH = body.UPPER_ARM, body.FOREARM
_FASTEST, _FASTEST_ASIDE = 2.6, 1.0  # nu beyond which steps get no longer, ahead and aside or back [1/s]

# The foot: spheres at the heel and at the toes, seen from the ankle, which is above them.
_SOLE = _RADII[_FOOT]
_DROP = body.ANKLE - _SOLE
_BACK = 0.035 - _SOLE
_BALL = body.FOOT - 0.035 - _SOLE
_TOE_OUT = 6.0 * _DEGREE
_TOE_OUT_COS, _TOE_OUT_SIN = math.cos(_TOE_OUT), math.sin(_TOE_OUT)

# Its roll at a full stride: toes up when it lands, heel up when it leaves; and the shares of the stance they take.
_LANDING, _LANDED = 20.0 * _DEGREE, 0.18
_PUSH, _PUSH_BEGINS = 70.0 * _DEGREE, 0.45
_FULL_STRIDE = 0.70
_ROUNDING = 0.03  # of the change from ball to heel in the air, per roll: small enough to leave the stance as it is
_CLEARANCE = 0.012
_CENTRE = 0.10  # c: feet are behind the hips in the mean

_HIP_ASIDE = 0.5 * body.HIPS - _RADII[_THIGH]
_SHOULDER_ASIDE = 0.5 * body.SHOULDERS - _RADII[_UPPER_ARM]
_SHOULDER_ABOVE = body.SHOULDER - HIP - _RADII[_UPPER_ARM]
_LEG = 0.9975 * (_THIGH_LENGTH + _SHANK_LENGTH)  # never quite straight, or the knee would snap
_ABDUCTION_SIN, _ABDUCTION_COS = math.sin(6.0 * _DEGREE), math.cos(6.0 * _DEGREE)


class Cycle(NamedTuple):
    """One person's walk, whatever its phase."""

    nu: float
    """speed over hip height [1/s]"""
    stride: float
    duty: float
    ahead: float
    """cosine of the way, seen from the heading"""
    left: float
    """sine of the way, seen from the heading"""
    roll: float
    """how much of the full roll the feet do, 0 to 1"""
    lift: float
    """how high the foot swings at least"""
    track: float
    """how far the feet are to the left and to the right of the middle"""


class Foot(NamedTuple):
    """One foot, seen from the body: x ahead, y left, z above the floor."""

    x: float
    """of the ankle"""
    y: float
    z: float
    cos: float
    """of the foot's pitch, positive with the heel up"""
    sin: float


class Step(NamedTuple):
    """One person on both feet, or on one of them."""

    cycle: Cycle
    wave: float
    """cosine of the phase"""
    sway: float
    """of the hips to the left"""
    hip_z: float
    """above the floor"""
    yaw_cos: float
    """of the pelvis"""
    yaw_sin: float


@njit(cache=True, nogil=True, error_model="numpy")
def pose(position: Array, velocity: Array, heading: Array, stature: Array, gait_phase: Array) -> Array:
    """(N, 17, 7) capsules of N people: both ends (x, y, z) in the map, z up from the floor, and the radius [m].

    The order is that of `crowdcosim.body.SEGMENTS`, `crowdcosim.body.BODY_PART` says what they belong to.

    Args:
        position: (N, 2) centres [m]
        velocity: (N, 2) velocities [m/s]
        heading: (N,) direction of the body, counter-clockwise from x [rad]
        stature: (N,) body heights [m]
        gait_phase: (N,) phase of the walk, 0 when the left heel lands [cycles]
    """
    n = len(position)
    capsules = np.empty((n, CAPSULES, 7))
    for i in range(n):
        pose_one(
            position[i, 0],
            position[i, 1],
            velocity[i, 0],
            velocity[i, 1],
            heading[i],
            stature[i],
            gait_phase[i],
            capsules[i],
        )
    return capsules


@njit(cache=True, nogil=True, error_model="numpy")
def pose_one(
    x: float, y: float, vx: float, vy: float, heading: float, stature: float, gait_phase: float, capsules: Array
) -> None:
    """Write one person's capsules, as `pose` gives them, into `capsules`, (17, 7)."""
    cos, sin = math.cos(heading), math.sin(heading)
    step = _stand(cos * vx + sin * vy, cos * vy - sin * vx, stature, gait_phase, capsules)
    lean = 2.0 * _DEGREE * step.cycle.nu
    _trunk(step.sway, step.hip_z, step.yaw_cos, step.yaw_sin, lean, capsules)
    shoulder_x, shoulder_y = _SHOULDER_ASIDE * step.yaw_sin, _SHOULDER_ASIDE * step.yaw_cos
    ahead, z = lean * _SHOULDER_ABOVE, step.hip_z + _SHOULDER_ABOVE
    _arm(step.cycle, step.wave, 1.0, ahead + shoulder_x, step.sway + shoulder_y, z, 0, capsules)
    _arm(step.cycle, -step.wave, -1.0, ahead - shoulder_x, step.sway - shoulder_y, z, 1, capsules)
    _place(x, y, cos, sin, stature, CAPSULES, capsules)


@njit(cache=True, nogil=True, error_model="numpy")
def pose_legs(
    x: float, y: float, vx: float, vy: float, heading: float, stature: float, gait_phase: float, capsules: Array
) -> None:
    """As `pose_one`, but only the first `LEGS` capsules, in half the time."""
    cos, sin = math.cos(heading), math.sin(heading)
    _stand(cos * vx + sin * vy, cos * vy - sin * vx, stature, gait_phase, capsules)
    _place(x, y, cos, sin, stature, LEGS, capsules)


@njit(cache=True, nogil=True, error_model="numpy")
def _stand(ahead: float, left: float, stature: float, gait_phase: float, capsules: Array) -> Step:
    """Put the feet on the floor and the hips above them: write the legs."""
    cycle = cycle_of(ahead, left, stature)
    wave_cos, wave_sin = math.cos(2.0 * math.pi * gait_phase), math.sin(2.0 * math.pi * gait_phase)

    left_foot = foot_at(cycle, gait_phase - math.floor(gait_phase), 1.0)
    right_foot = foot_at(cycle, gait_phase + 0.5 - math.floor(gait_phase + 0.5), -1.0)
    sway = 0.128 * min(cycle.nu, 0.5) * (1.0 - min(cycle.nu, 0.5)) * HIP * _turned(wave_cos, wave_sin, 0.1)
    yaw = -4.0 * _DEGREE * cycle.nu * wave_cos
    yaw_cos, yaw_sin = math.cos(yaw), math.sin(yaw)
    x, y = -_HIP_ASIDE * yaw_sin, _HIP_ASIDE * yaw_cos
    rise = _turned(wave_cos * wave_cos - wave_sin * wave_sin, 2.0 * wave_cos * wave_sin, 0.35)
    hip_z = _soft_min(
        _soft_min(_reach(left_foot, x, sway + y), _reach(right_foot, -x, sway - y), 0.001 + 0.012 * cycle.roll),
        HIP * (1.0 + 0.015 * cycle.nu * (rise - 1.0)),
        0.001 + 0.012 * cycle.roll,
    )
    _leg(left_foot, 1.0, x, sway + y, hip_z, 0, capsules)
    _leg(right_foot, -1.0, -x, sway - y, hip_z, 1, capsules)
    return Step(cycle, wave_cos, sway, hip_z, yaw_cos, yaw_sin)


@njit(cache=True, nogil=True, error_model="numpy")
def cycle_of(ahead: float, left: float, stature: float) -> Cycle:
    """The walk at a velocity [m/s] ahead and to the left, at a body height [m]."""
    hip = HIP * stature
    speed = math.sqrt(ahead * ahead + left * left)
    if speed > 0.0:
        ahead, left = ahead / speed, left / speed
    speed = min(speed, (_FASTEST_ASIDE + (_FASTEST - _FASTEST_ASIDE) * max(ahead, 0.0)) * hip)
    time = cycle_time(speed, stature)
    stride = speed * time / stature
    share = min(stride / _FULL_STRIDE, 1.0)
    walking = min(2.0 * speed / hip, 1.0)
    return Cycle(
        speed / hip,
        stride,
        duty(time),
        ahead,
        left,
        share * max(ahead, 0.0),
        _CLEARANCE * min(2.0 * share, 1.0),
        _HIP_ASIDE - 0.024 * walking,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def foot_at(cycle: Cycle, phase: float, side: float) -> Foot:
    """The foot at `phase` after it landed, in [0, 1); `side` is 1 for the left and -1 for the right one."""
    front = cycle.stride * (0.5 * cycle.duty - _CENTRE)
    landing, push = -_LANDING * cycle.roll, _PUSH * cycle.roll
    pitch = clearance = rounding = 0.0
    if phase < cycle.duty:
        way = front - cycle.stride * phase
        share = phase / cycle.duty
        if share < _LANDED:
            pitch = landing * (1.0 - share / _LANDED) ** 2
        elif share > _PUSH_BEGINS:
            risen = (share - _PUSH_BEGINS) / (1.0 - _PUSH_BEGINS)
            pitch = push * risen * math.sqrt(risen)
    else:
        swing = 1.0 - cycle.duty
        u = (phase - cycle.duty) / swing
        slope = -cycle.stride * swing
        way = _hermite(front - cycle.stride * cycle.duty, slope, front, slope, u)
        pitch = _hermite(push, 1.5 * push * swing / ((1.0 - _PUSH_BEGINS) * cycle.duty), landing, 0.0, u)
        clearance = cycle.lift * 16.0 * (u * (1.0 - u)) ** 2
        rounding = _ROUNDING * cycle.roll
    cos, sin = math.cos(pitch), math.sin(pitch)
    pivot = _BALL if pitch > 0.0 else -_BACK
    ahead = pivot * (1.0 - cos) + _DROP * sin  # of the ankle, by the pitch
    up = -_soft_min(-_BALL * sin, _BACK * sin, rounding)
    return Foot(
        way * cycle.ahead + ahead * _TOE_OUT_COS,
        way * cycle.left + side * (cycle.track + ahead * _TOE_OUT_SIN),
        _SOLE + _DROP * cos + up + clearance,
        cos,
        sin,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _hermite(a: float, slope_a: float, b: float, slope_b: float, u: float) -> float:
    """The cubic from `a` at u = 0 to `b` at u = 1 with these slopes."""
    return a + u * (slope_a + u * (3.0 * (b - a) - 2.0 * slope_a - slope_b + u * (2.0 * (a - b) + slope_a + slope_b)))


@njit(cache=True, nogil=True, error_model="numpy")
def _soft_min(a: float, b: float, width: float) -> float:
    """At most the smaller of the two, and that itself where they differ by more than `width`."""
    overlap = width - abs(a - b)
    if overlap <= 0.0:
        return min(a, b)
    return min(a, b) - 0.25 * overlap * overlap / width


@njit(cache=True, nogil=True, error_model="numpy")
def _turned(cos: float, sin: float, cycles: float) -> float:
    """sin(angle - 2 pi cycles) from the angle's cosine and sine."""
    return sin * math.cos(2.0 * math.pi * cycles) - cos * math.sin(2.0 * math.pi * cycles)


@njit(cache=True, nogil=True, error_model="numpy")
def _reach(foot: Foot, x: float, y: float) -> float:
    """How high the hip at (x, y) can be."""
    aside = (foot.x - x) ** 2 + (foot.y - y) ** 2
    return foot.z + math.sqrt(max(_LEG * _LEG - aside, 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _set(capsules: Array, index: int, ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> None:
    capsules[index, 0], capsules[index, 1], capsules[index, 2] = ax, ay, az
    capsules[index, 3], capsules[index, 4], capsules[index, 5] = bx, by, bz


@njit(cache=True, nogil=True, error_model="numpy")
def _leg(foot: Foot, side: float, x: float, y: float, z: float, index: int, capsules: Array) -> None:
    """Foot, shank and thigh below the hip at (x, y, z); the knee bends to where the toes point."""
    toe_x, toe_y = _TOE_OUT_COS, side * _TOE_OUT_SIN
    # The sole's spheres below the ankle: pitched, (x, z) becomes (x cos + z sin, z cos - x sin).
    ball, ball_z = _BALL * foot.cos - _DROP * foot.sin, -_BALL * foot.sin - _DROP * foot.cos
    heel, heel_z = -_BACK * foot.cos - _DROP * foot.sin, _BACK * foot.sin - _DROP * foot.cos
    _set(
        capsules,
        _FOOT + index,
        foot.x + heel * toe_x,
        foot.y + heel * toe_y,
        foot.z + heel_z,
        foot.x + ball * toe_x,
        foot.y + ball * toe_y,
        foot.z + ball_z,
    )
    dx, dy, dz = foot.x - x, foot.y - y, foot.z - z
    square = dx * dx + dy * dy + dz * dz
    along = (_THIGH_LENGTH * _THIGH_LENGTH - _SHANK_LENGTH * _SHANK_LENGTH + square) / (2.0 * square)
    bend = math.sqrt(max(_THIGH_LENGTH * _THIGH_LENGTH - along * along * square, 0.0))
    share = (toe_x * dx + toe_y * dy) / square
    nx, ny, nz = toe_x - share * dx, toe_y - share * dy, -share * dz
    bend /= math.sqrt(nx * nx + ny * ny + nz * nz)
    knee_x, knee_y, knee_z = x + along * dx + bend * nx, y + along * dy + bend * ny, z + along * dz + bend * nz
    _set(capsules, _SHANK + index, foot.x, foot.y, foot.z, knee_x, knee_y, knee_z)
    _set(capsules, _THIGH + index, knee_x, knee_y, knee_z, x, y, z)


@njit(cache=True, nogil=True, error_model="numpy")
def _trunk(sway: float, z: float, cos: float, sin: float, lean: float, capsules: Array) -> None:
    """Pelvis, both sides of the trunk, neck and head above the hips; the shoulders turn against the pelvis."""
    _set(capsules, _PELVIS, -0.034 * sin, sway + 0.034 * cos, z + 0.015, 0.034 * sin, sway - 0.034 * cos, z + 0.015)
    for index in range(2):
        side = 1.0 - 2.0 * index
        low, high = side * 0.030, side * 0.052
        _set(
            capsules,
            _TRUNK + index,
            -low * sin + lean * 0.05,
            sway + low * cos,
            z + 0.06,
            high * sin + lean * 0.23,
            sway + high * cos,
            z + 0.23,
        )
    _set(capsules, _NECK, lean * 0.25, sway, z + 0.26, lean * 0.35, sway, z + 0.35)
    top = z + 0.470 - _RADII[_HEAD]
    _set(capsules, _HEAD, lean * 0.41 + 0.010, sway, top - 0.045, lean * 0.41 + 0.010, sway, top)


@njit(cache=True, nogil=True, error_model="numpy")
def _arm(cycle: Cycle, wave: float, side: float, x: float, y: float, z: float, index: int, capsules: Array) -> None:
    """Upper arm, forearm and hand below the shoulder; `wave` is cos 2 pi phi of this side's leg."""
    swing = 9.88 * cycle.nu
    shoulder = (3.0 - 0.5 * swing - swing * wave) * _DEGREE
    walking = min(2.0 * cycle.nu, 1.0)
    elbow = shoulder + (13.0 - 7.0 * wave * walking) * _DEGREE
    out = side * _ABDUCTION_SIN * _UPPER_ARM_LENGTH
    cos, sin = math.cos(shoulder), math.sin(shoulder)
    length = _ABDUCTION_COS * _UPPER_ARM_LENGTH
    elbow_x, elbow_y, elbow_z = x + length * sin, y + out, z - length * cos
    cos, sin = math.cos(elbow), math.sin(elbow)
    wrist_x, wrist_z = elbow_x + _FOREARM_LENGTH * sin, elbow_z - _FOREARM_LENGTH * cos
    _set(capsules, _UPPER_ARM + index, x, y, z, elbow_x, elbow_y, elbow_z)
    _set(capsules, _FOREARM + index, elbow_x, elbow_y, elbow_z, wrist_x, elbow_y, wrist_z)
    _set(
        capsules,
        _HAND + index,
        wrist_x + 0.02 * sin,
        elbow_y,
        wrist_z - 0.02 * cos,
        wrist_x + 0.07 * sin,
        elbow_y,
        wrist_z - 0.07 * cos,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _place(x: float, y: float, cos: float, sin: float, stature: float, count: int, capsules: Array) -> None:
    """Turn the first capsules' fractions of stature into metres of the map."""
    cos, sin = stature * cos, stature * sin
    for index in range(count):
        for end in (0, 3):
            ahead, left = capsules[index, end], capsules[index, end + 1]
            capsules[index, end] = x + cos * ahead - sin * left
            capsules[index, end + 1] = y + sin * ahead + cos * left
            capsules[index, end + 2] *= stature
        capsules[index, 6] = _RADII[index] * stature
