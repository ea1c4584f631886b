"""Who ran into whom, and how hard."""

from __future__ import annotations

from typing import Any

import pytest

from crowdcosim.messages import Contacts


def touched(scene: Any, touches: Any) -> dict[str, Any]:
    return scene.judge(scene.drive(10, crowd=lambda t: scene.crowd([(t, 9.0)]), touches=touches))


def test_whoever_moves_towards_the_other_faster_is_the_one_who_ran(scene: Any) -> None:
    found = touched(
        scene,
        {
            2: [{"approach_speed": 1.0, "robot_closing_speed": 0.9}],
            4: [{"approach_speed": 1.0, "robot_closing_speed": 0.4}],
            6: [{"approach_speed": 1.0, "robot_closing_speed": 0.5}],  # a draw is the person's
            8: [{"approach_speed": 0.3, "robot_closing_speed": -0.2}],  # the robot flees
        },
    )
    assert (found["collisions"], found["robot_on_person"], found["person_on_robot"]) == (4.0, 1.0, 3.0)


def test_energies_add_up_and_the_hardest_is_kept(scene: Any) -> None:
    found = touched(
        scene, {2: [{"energy": 2.0}, {"energy": 5.0}], 3: [{"energy": 2.0, "duration": 0.1}], 7: [{"energy": 1.0}]}
    )
    assert found["collision_energy"] == pytest.approx(8.0)
    assert found["collision_energy_max"] == 5.0
    assert found["collision_energy_rate"] == pytest.approx(8.0)  # in one second
    assert found["collisions"] == 3.0


def test_walls_and_robots_are_not_people_and_counted_apart(scene: Any) -> None:
    wall, robot = {"kind": Contacts.WALL, "energy": 9.0}, {"kind": Contacts.ROBOT}
    found = touched(scene, {2: [wall], 3: [wall | {"duration": 0.1}, robot], 5: [wall]})
    assert (found["collisions"], found["collision_energy_max"]) == (0.0, 0.0)
    assert (found["wall_collisions"], found["robot_collisions"]) == (2.0, 1.0)


def test_without_a_report_nothing_is_said(scene: Any) -> None:
    frames = [(crowd, robots, ()) for crowd, robots, _ in scene.drive(5, crowd=lambda t: scene.crowd([(t, 9.0)]))]
    found = scene.judge(frames)
    assert all("nobody reports" in found[n] for n in ("collisions", "robot_on_person", "collision_energy_max"))
