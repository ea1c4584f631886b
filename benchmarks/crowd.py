"""How long a crowd's step takes: microseconds per person for every policy, beside JuPedSim where that is installed.

    python benchmarks/crowd.py [--people 50 350 1000 5000] [--policies orca rvo ...] [--cold]

People walk both ways through a periodic corridor of 50 m x 10 m, at more than 350 people through a wider one at 0.7 per
square metre; a step is the policy and the motion, on one thread. JuPedSim's people walk the same ways through a room
without seams. Absolute values differ from machine to machine and from minute to minute: compare within one run.

`--cold` says instead what compiling costs: the processor time of the first step with an empty cache, in a process each.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np

from components.crowd.motion import move
from components.crowd.placement import place
from components.crowd.policies import PolicyName, make_policy
from components.crowd.sampling import next_streams
from components.crowd.scene import Scene
from components.crowd.walls import Walls
from crowdcosim.world import World

WARM_UP = 20
"""steps before the clock starts, in which lanes begin to form"""
ROUNDS = 5
"""the quickest counts: whatever else the machine does only adds"""
MANY, FEW = 10_000, 3
"""with more people than this, steps before the clock starts and rounds are fewer"""
DENSITY = 0.7
"""[1/m2]"""

Step = Callable[[], None]


def world_of(people: int) -> World:
    """The corridor, as wide as the people need."""
    return World(size=(50.0, max(10.0, people / DENSITY / 50.0)), periodic=(True, True))


def people_at_start(people: int) -> Scene:
    """Half of them walk along x, half against it."""
    rng, world = np.random.default_rng(1), world_of(people)
    position = place(rng, np.full(people, 0.3), world, np.empty((0, 3)))
    speed = np.clip(rng.normal(1.3, 0.2, people), 0.8, 1.8)
    preferred = np.column_stack([np.where(np.arange(people) % 2, -speed, speed), np.zeros(people)])
    return Scene(
        position=position,
        velocity=preferred.copy(),
        preferred=preferred,
        radius=np.full(people, 0.3),
        robots=np.empty((0, 5)),
        pushed_by_robots=np.ones(people, np.bool_),
        walls=Walls(np.empty((0, 2, 2)), world.period),
        period=world.period.copy(),
        max_speed=np.full(people, 1.8),
        max_acceleration=np.full(people, 5.0),
        stream=rng.integers(0, 2**64, people, np.uint64),
        dt=0.1,
    )


def own_step(name: PolicyName, people: int) -> Step:
    """One step of ours."""
    policy, scene = make_policy(name, time_horizon=1.5), people_at_start(people)

    def step() -> None:
        nonlocal scene
        position, velocity = move(scene, policy.accelerate(scene))
        scene = replace(scene, position=position, velocity=velocity, stream=next_streams(scene.stream))

    return step


def jupedsim_models() -> dict[str, tuple[Any, Any]]:
    """Name -> operational model and its agents' parameters; empty where JuPedSim is not installed."""
    try:
        import jupedsim as jps
    except ImportError:
        return {}
    return {
        "JuPedSim social force": (jps.SocialForceModel, jps.SocialForceModelAgentParameters),
        "JuPedSim collision-free speed": (jps.CollisionFreeSpeedModel, jps.CollisionFreeSpeedModelAgentParameters),
    }


def jupedsim_step(model: Any, parameters: Any, people: int) -> Step:
    """One step of JuPedSim, without seams."""
    import jupedsim as jps

    scene, (length, width) = people_at_start(people), world_of(people).size
    room = [(-50.0, -1.0), (length + 50.0, -1.0), (length + 50.0, width + 1.0), (-50.0, width + 1.0)]
    simulation = jps.Simulation(model=model(), geometry=room, dt=0.01)
    journeys = []
    for x in (length + 48.0, -49.0):
        exit_ = simulation.add_exit_stage([(x, -0.9), (x + 1, -0.9), (x + 1, width + 0.9), (x, width + 0.9)])
        journeys.append((simulation.add_journey(jps.JourneyDescription([exit_])), exit_))
    for i, (x, y) in enumerate(scene.position):
        journey, stage = journeys[i % 2]
        simulation.add_agent(parameters(position=(x, y), radius=0.25, journey_id=journey, stage_id=stage))
    return simulation.iterate  # type: ignore[no-any-return]


def seconds(step: Step) -> float:
    """Of one step, the mean of some."""
    count, begin = 0, time.perf_counter()
    while count < 2 or time.perf_counter() - begin < 0.03:
        step()
        count += 1
    return (time.perf_counter() - begin) / count


def print_table(policies: Sequence[PolicyName], people: Sequence[int]) -> None:
    """Rows of microseconds per person."""
    rows: dict[str, Callable[[int], Step]] = {name: partial(own_step, name) for name in policies}
    for name, (model, parameters) in jupedsim_models().items():
        rows[name] = partial(jupedsim_step, model, parameters)
    columns = []
    for count in people:
        steps = [make_step(count) for make_step in rows.values()]
        for step in steps:
            for _ in range(WARM_UP if count <= MANY else FEW):
                step()
        # All of them in turn, so that a slow minute of the machine is slow for all.
        rounds = ROUNDS if count <= MANY else FEW
        columns.append(np.min([[seconds(step) for step in steps] for _ in range(rounds)], axis=0) * 1e6 / count)
    print(f"{'us per person and step':30s}" + "".join(f"{count:>9d}" for count in people))
    for name, times in zip(rows, np.transpose(columns), strict=True):
        print(f"{name:30s}" + "".join(f"{t:9.2f}" for t in times))


def print_cold(policies: Sequence[PolicyName]) -> None:
    """Seconds of processor time that the first step takes with an empty cache."""
    print(f"{'s of processor time':30s}")
    for name in policies:
        with tempfile.TemporaryDirectory() as cache:
            code = (
                "import time; from benchmarks.crowd import own_step; s = own_step; "
                f"b = time.process_time(); s('{name}', 20)(); print(time.process_time() - b)"
            )
            result = subprocess.run(
                [sys.executable, "-c", code],
                env={**os.environ, "NUMBA_CACHE_DIR": cache},
                capture_output=True,
                text=True,
                check=True,
            )
        print(f"{name:30s}{float(result.stdout):9.1f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--people", type=int, nargs="+", default=[50, 350, 1000, 5000])
    parser.add_argument("--policies", nargs="+", choices=get_args(PolicyName), default=get_args(PolicyName))
    parser.add_argument("--cold", action="store_true")
    arguments = parser.parse_args()
    if arguments.cold:
        print_cold(arguments.policies)
    else:
        print_table(arguments.policies, arguments.people)


if __name__ == "__main__":
    main()
