"""How fast crowds come through doors: people per second and metre of width, beside published values.

    python benchmarks/doors.py [--widths 0.9 1.2 2.0] [--policies orca social_force power_law]

80 people leave a room of 12 m x 10 m through a door in the middle of a wall without depth; the flow is that of the
middle 70% of them. Published: 1.3 /(m s) (SFPE Handbook of Fire Protection Engineering) to about 2 /(m s) (Kretz,
Gruenebohm and Schreckenberg 2006, "Experimental study of pedestrian flow through a bottleneck"; Seyfried et al. 2009,
"New insights into pedestrian flow through bottlenecks").
"""

from __future__ import annotations

import argparse

import numpy as np

from components.crowd.crowd import CrowdModel
from crowdcosim.component import make
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World

PEOPLE, LINE = 80, 12.0
"""how many, and where the door is [m]"""
AREAS = {"room": {"x": [3, 11], "y": [0, 10]}, "outside": {"x": [18, 20], "y": [0, 10]}}
LIMIT = 1500
"""steps of 0.1 s"""


def world(width: float) -> World:
    """The room, its door and the space behind."""
    corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]
    ends = [*zip(corners, corners[1:] + corners[:1], strict=True)]
    ends += [((LINE, 0.0), (LINE, 5 - width / 2)), ((LINE, 5 + width / 2), (LINE, 10.0))]
    return World(size=(20.0, 10.0), walls=tuple(Wall(start=a, end=b) for a, b in ends))


def times_through(policy: str, width: float) -> list[float]:
    """When each of those came through the door who did, in this order [s]."""
    journeys = [{"start": "room", "goal": "outside", "count": PEOPLE}]
    model = make(CrowdModel, {"policy": policy, "areas": AREAS, "journeys": journeys})
    crowd = model.reset(Setup(component="crowd", period=100_000_000, seed=1, world=world(width)))
    times: dict[int, float] = {}
    for step in range(LIMIT):
        for person in crowd.id[crowd.position[:, 0] > LINE].tolist():
            times.setdefault(person, 0.1 * step)
        if len(times) == PEOPLE:
            break
        crowd = model.step(())
    return sorted(times.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--widths", type=float, nargs="+", default=[0.9, 1.2, 2.0])
    parser.add_argument("--policies", nargs="+", default=["social_force", "orca", "power_law"])
    arguments = parser.parse_args()
    print(f"{'/(m s)':16s}" + "".join(f"{width:>8g} m" for width in arguments.widths))
    for policy in arguments.policies:
        cells = []
        for width in arguments.widths:
            times = np.array(times_through(policy, width))
            first, last = int(0.15 * PEOPLE), min(int(0.85 * PEOPLE), len(times) - 1)
            flow = (last - first) / (times[last] - times[first]) / width
            cells.append(f"{flow:9.2f}" + ("*" if len(times) < PEOPLE else " "))
        print(f"{policy:16s}" + "".join(cells), flush=True)
    print(f"* not all came through within {0.1 * LIMIT:g} s")


if __name__ == "__main__":
    main()
