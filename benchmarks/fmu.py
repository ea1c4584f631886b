"""What an FMU costs per communication step, beside the same motors as a native kernel: microseconds.

    python benchmarks/fmu.py [--steps 5000]

`overhead` is set + step + get with a communication step of one inner step of the model (0.2 ms), so that there is next
to nothing to compute; `10 ms` has 50 inner steps, as in a scenario of dt = 0.1 s. The quickest of some rounds counts:
whatever else the machine does only adds. At most 20 us of overhead is what we allow; beyond that the script fails.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

from components.robot.fmu_build import built_in
from components.robot.fmu_instance import FmuInstance
from components.robot.motor import INNER_STEP, TURTLEBOT2, Motor, NativeMotors

ROUNDS = 7
ALLOWED = 20.0
"""[us]"""


def quickest(step: Callable[[int], object], steps: int) -> float:
    """Microseconds per step."""
    best = float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for k in range(steps):
            step(k)
        best = min(best, time.perf_counter() - begin)
    return best / steps * 1e6


def fmu_step(version: str, h: float) -> Callable[[int], object]:
    """One communication step of the built-in FMU, with its four inputs set and two outputs got."""
    instance = FmuInstance(built_in("2" if version == "2" else "3"), "benchmark")
    instance.start({})
    give = instance.access(["left_command", "right_command", "left_load", "right_load"])
    take = instance.access(["left_speed", "right_speed"])
    inputs = [10.0, 5.0, 0.0, 0.0]

    def step(k: int) -> object:
        give.set(inputs)
        instance.step(k * h, h)
        return take.get()

    return step


def native_step(h: float) -> Callable[[int], object]:
    motors = NativeMotors(Motor(), TURTLEBOT2)
    return lambda k: motors.step((10.0, 5.0), (0.0, 0.0), h)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=5000, help="communication steps per round")
    steps = parser.parse_args().steps
    worst = 0.0
    print(f"{'':10} {'overhead':>10} {'10 ms':>10}")
    for name, of in (
        ("native", native_step),
        ("FMI 2.0", lambda h: fmu_step("2", h)),
        ("FMI 3.0", lambda h: fmu_step("3", h)),
    ):
        overhead, whole = quickest(of(INNER_STEP), steps), quickest(of(0.01), steps)
        worst = max(worst, overhead)
        print(f"{name:10} {overhead:7.1f} us {whole:7.1f} us")
    print(f"allowed    {ALLOWED:7.1f} us")
    return int(worst > ALLOWED)


if __name__ == "__main__":
    sys.exit(main())
