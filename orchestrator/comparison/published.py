"""What "Crowd against the machine" (Grzeskowiak et al. 2021) reports in numbers, by controller."""

from __future__ import annotations

COLLISION_RATE = {"baseline": 0.624, "dwa": 0.610, "rvo": 0.311}
"""f_c over all simulations [1/s], section V-B"""
COLLISION_ENERGY_RATE = {"baseline": 2.568, "dwa": 2.285, "rvo": 0.901}
"""Q over all simulations [J/s], section V-B"""

_ORDER = (
    "time_ratio",
    "path_length_ratio",
    "velocity_variation_ratio",
    "neighbour_reaction",
    "neighbour_velocity",
    "proximity",
    "colliding",
)
_HIGH = {
    "baseline": (0.190, 0.00, 0.238, 1.022, 0.070, 0.132, 0.132),
    "dwa": (0.257, 0.225, 0.289, 0.488, 0.089, 0.175, 0.117),
    "rvo": (0.236, 0.100, 0.015, 1.052, 0.129, 0.141, 0.092),
}
_LOW = {
    "baseline": (0.022, 0.00, 0.244, 1.402, 0.084, 0.164, 0.027),
    "dwa": (0.171, 0.123, 0.280, 0.807, 0.096, 0.171, 0.040),
    "rvo": (0.145, 0.067, 0.029, 1.863, 0.125, 0.149, 0.031),
}

DEVIATIONS = {
    density: {controller: dict(zip(_ORDER, row, strict=True)) for controller, row in table.items()}
    for density, table in (("all", _HIGH), ("low", _LOW))
}
"""table I: "high density" is over all four densities, "low" over 0.1 /m2; the means are in a figure only"""
