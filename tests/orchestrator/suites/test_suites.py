"""The suites: what is generated is what is shipped, and the hundred are the paper's hundred."""

from __future__ import annotations

from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from orchestrator.errors import InputError
from orchestrator.scenario.scenario import Scenario, load
from orchestrator.scenario.shipped import scenarios_folder, suite_names
from orchestrator.suites.catalogue import GENERATORS, find_suite, generator
from orchestrator.suites.frozen import write
from orchestrator.suites.paper import TURTLEBOT2
from orchestrator.suites.placing import place


@pytest.fixture(scope="module")
def hundred() -> list[Scenario]:
    return [load(str(file)) for file in find_suite("paper").files]


@pytest.mark.parametrize("name", suite_names())
def test_a_shipped_suite_is_what_its_generator_writes_byte_for_byte(name: str, tmp_path: Path) -> None:
    written = write(generator(name).files(), tmp_path)
    shipped = find_suite(name).files
    assert sorted(path.name for path in written) == [path.name for path in shipped]
    assert [path.name for path in shipped if path.read_bytes() != (tmp_path / path.name).read_bytes()] == []


def test_the_hundred_are_five_behaviours_by_four_densities_by_five_flows(hundred: list[Scenario]) -> None:
    crowds = [s.component("crowd").config for s in hundred]
    behaviours = [(c["policy"], c["time_horizon"] if c["policy"] == "orca" else None, c["reactive"]) for c in crowds]
    cells = list(zip(behaviours, (len(c["positions"]) for c in crowds), (c["flow"] for c in crowds), strict=True))
    paper = [("orca", 0.5, True), ("orca", 0.5, False), ("orca", 1.5, True), ("orca", 1.5, False)]
    expected = product([*paper, ("social_force", None, True)], (50, 100, 200, 350), ("1d+", "1d-", "1dx", "2d", "2dx"))
    assert Counter(cells) == Counter(expected)
    assert sorted(s.seed for s in hundred) == list(range(1, 101))


def test_the_hundred_differ_in_nothing_but_the_crowd_and_its_seed(hundred: list[Scenario]) -> None:
    def rest(scenario: Scenario) -> dict[str, object]:
        free = ("name", "description", "seed", "crowd")
        return {key: value for key, value in scenario.resolved.items() if key not in free}

    assert all(rest(scenario) == rest(hundred[0]) for scenario in hundred)
    assert hundred[0].world == load("corridor").world
    (frozen,), (shipped,) = hundred[0].robots, load("corridor").robots
    assert {name: getattr(shipped.model, name) for name in TURTLEBOT2} == TURTLEBOT2
    assert (frozen.start, frozen.goal) == (shipped.start, shipped.goal)


def test_nobody_of_the_hundred_overlaps_anybody_at_the_start(hundred: list[Scenario]) -> None:
    for scenario in hundred:
        crowd = scenario.component("crowd").config
        position = np.array(crowd["positions"])
        i, j = np.triu_indices(len(position), 1)
        gap = np.hypot(*scenario.world.displacement(position[i], position[j]).T)
        assert gap.min() >= 2 * crowd["radius"] - 1e-9  # as written; rounding of binary fractions
        (robot,) = scenario.robots
        start = np.array([robot.start.x, robot.start.y])
        nearest = np.hypot(*scenario.world.displacement(start, position).T).min()
        assert nearest >= crowd["radius"] + robot.model.radius - 1e-9


def test_places_are_uniform_over_the_world() -> None:
    x, y = place(1, 350, radius=0.3, size=(50.0, 10.0), keep_free=(5.0, 5.0, 0.2)).T
    # The mean of 350 uniform draws is within 3.3 standard errors, extent / sqrt(12 * 350), in 999 of 1000 cases.
    assert abs(x.mean() - 25) < 3.3 * 50 / np.sqrt(12 * 350)
    assert abs(y.mean() - 5) < 3.3 * 10 / np.sqrt(12 * 350)


@pytest.mark.parametrize("name", sorted(set(GENERATORS) - set(suite_names())))
def test_suites_that_are_not_shipped_load(name: str, tmp_path: Path) -> None:
    files = write(generator(name).files(), tmp_path / name)
    assert [path.stem for path in files] == [load(str(path)).name for path in files]
    assert find_suite(str(tmp_path / name)).name == name


def test_a_scenario_of_a_suite_has_a_name_for_the_command_line() -> None:
    assert load("paper/sf-reactive_2d_050").name == "sf-reactive_2d_050"
    assert (scenarios_folder() / "paper/sf-reactive_2d_050.yaml").is_file()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [("papr", r"no suite 'papr' \(did you mean 'paper'\?\)"), ("robots", "crowdcosim generate"), ("x/y", "no suite")],
)
def test_a_suite_that_is_not_there_is_refused(wrong: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        find_suite(wrong)


def test_an_empty_folder_is_no_suite(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no scenario"):
        find_suite(str(tmp_path))


def test_a_generator_that_is_not_there_is_refused() -> None:
    with pytest.raises(InputError, match=r"did you mean 'smoke'"):
        generator("smok")
