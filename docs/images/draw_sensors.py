"""Draws `sensors.png`: what the sensors of the scenario `sensors` tell: `python docs/images/draw_sensors.py`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Wedge

from crowdcosim import Session
from crowdcosim.messages import BeamAgents
from orchestrator.scenario.mounts import sensor_frames
from orchestrator.scenario.scenario import load

SECONDS, REACH = 12.0, 5.2
COLOURS = {BeamAgents.WALL: "#7f8c8d", BeamAgents.PERSON: "#d35400"}
BLUE, GREEN = "#2471a3", "#1e8449"


def main() -> None:
    """Run the scenario up to a moment and draw four views of it."""
    matplotlib.use("Agg")
    plt.rcParams.update({"font.size": 8, "axes.titlesize": 9, "axes.linewidth": 0.5})
    scenario = load("sensors")
    frames = {
        name: mount
        for spec in scenario.components
        if spec.robot
        for name, mount in sensor_frames(spec, scenario.robots[0].model).items()
    }
    imu = []
    with Session("sensors", {"crowd.config.count": 200}, seed=3) as session:
        while session.view.time < SECONDS and not session.over:
            imu.append((session.view.time, session.view.robot.sensors["imu"]))
            session.step()
        view = session.view

    figure = plt.figure(figsize=(9.0, 5.0), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=[3.2, 1.0])
    panels = [figure.add_subplot(grid[0, k]) for k in range(3)]
    people = in_robot(view.crowd.position - view.robot.state.position, view.robot.state.heading)
    for panel, title in zip(panels, ("two LiDARs", "twelve ultrasounds", "people tracker, 0.1 s late"), strict=True):
        draw_place(panel, people, view.crowd.radius, view.robot.state.radius)
        panel.set_title(title)
    draw_scans(panels[0], view.robot.sensors, frames)
    draw_cones(panels[1], view.robot.sensors, frames)
    draw_tracks(panels[2], view.robot.sensors)
    draw_imu(figure.add_subplot(grid[1, :]), imu)
    figure.savefig(Path(__file__).with_name("sensors.png"), dpi=110)


def in_robot(offset: np.ndarray, heading: float) -> np.ndarray:
    """(N, 2) vectors of the map, seen from a robot [m]."""
    cos, sin = math.cos(heading), math.sin(heading)
    return offset @ np.array([[cos, -sin], [sin, cos]])


def draw_place(ax: Axes, people: np.ndarray, radius: np.ndarray, robot: float) -> None:
    """Where people truly are, in grey, and the robot, which looks to the right."""
    for centre, r in zip(people, radius, strict=True):
        ax.add_patch(Circle(tuple(centre), r, color="0.9", zorder=0))
    ax.add_patch(Circle((0, 0), robot, color="0.2", zorder=3))
    ax.plot([0, robot], [0, 0], color="white", linewidth=1.5, zorder=4)
    ax.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), aspect="equal", xticks=[-4, 0, 4], yticks=[-4, 0, 4])
    ax.set_xlabel("ahead [m]")


def draw_scans(ax: Axes, sensors: Mapping, frames: Mapping) -> None:
    """Every beam's end, by what it has hit."""
    for name in ("front", "rear"):
        scan, agents = sensors[f"{name}/scan"], sensors[f"{name}/agents"]
        mount = frames[f"robot/{name}"]
        angles = mount.yaw + scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        for kind, colour in COLOURS.items():
            hit = np.isfinite(scan.ranges) & (agents.kind == kind)
            r = scan.ranges[hit]
            x, y = mount.position[0] + r * np.cos(angles[hit]), mount.position[1] + r * np.sin(angles[hit])
            ax.plot(x, y, ".", markersize=1.6, color=colour)


def draw_cones(ax: Axes, sensors: Mapping, frames: Mapping) -> None:
    """A cone as long as its reading; a pale one where there is no echo."""
    for reading in sensors["sonar/ranges"].ranges:
        mount = frames[reading.header.frame_id]
        echo = math.isfinite(reading.range)
        middle, half = math.degrees(mount.yaw), 0.5 * math.degrees(reading.field_of_view)
        ax.add_patch(
            Wedge(
                mount.position[:2],
                reading.range if echo else reading.max_range,
                middle - half,
                middle + half,
                color=BLUE,
                linewidth=0,
                alpha=0.45 if echo else 0.08,
            )
        )


def draw_tracks(ax: Axes, sensors: Mapping) -> None:
    """Detections with their track's number and velocity."""
    found = sensors["people/detections"]
    for centre, velocity, radius, track in zip(found.position, found.velocity, found.radius, found.track, strict=True):
        if np.abs(centre).max() < REACH:
            ax.add_patch(Circle(tuple(centre), radius, fill=False, color=GREEN, linewidth=1.0))
            ax.annotate(str(track), centre, fontsize=6, ha="center", va="center", color=GREEN)
            ax.arrow(*centre, *(0.6 * velocity), width=0.02, head_width=0.15, color=GREEN, alpha=0.6, linewidth=0)


def draw_imu(ax: Axes, imu: list) -> None:
    """Acceleration ahead and turn rate over time."""
    times = [time for time, _ in imu]
    ax.plot(times, [m.linear_acceleration.x for _, m in imu], color=COLOURS[BeamAgents.PERSON], linewidth=0.9)
    ax.plot(times, [m.angular_velocity.z for _, m in imu], color=BLUE, linewidth=0.9)
    ax.set(title="IMU", xlabel="time [s]", xlim=(0, SECONDS), ylim=(-6, 9))
    ax.legend(["acceleration ahead [m/s2]", "turn rate [rad/s]"], frameon=False, ncols=2, loc="upper right")


if __name__ == "__main__":
    main()
