"""Draw `avatar.png`, frames of the walking body: `python docs/images/draw_avatar.py`."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from crowdcosim.avatar import pose
from crowdcosim.body import BODY_PART, SEGMENTS
from crowdcosim.gait import phase_rate
from crowdcosim.messages import Contacts

STATURE = 1.75
FRAMES = 9
COLOURS = {
    Contacts.FEET: (0.20, 0.16, 0.14),
    Contacts.LOWER_LEGS: (0.20, 0.33, 0.55),
    Contacts.UPPER_LEGS: (0.27, 0.45, 0.72),
    Contacts.UPPER_BODY: (0.85, 0.48, 0.30),
}
SKIN = (0.93, 0.76, 0.64)
VIEWS = {"side": (0, 2), "front": (1, 2), "top": (0, 1)}
"""axes to the right and up"""


def draw(axes: Axes, capsules: NDArray[np.float64], view: str, offset: tuple[float, float] = (0.0, 0.0)) -> None:
    """Draw the (17, 7) capsules of one person, the nearest last."""
    right, up = VIEWS[view]
    x, y, z = (capsules[:, [axis, axis + 3]] for axis in range(3))
    nearness = {"side": -y.mean(1), "front": x.mean(1), "top": z.max(1)}
    for k in np.argsort(nearness[view], kind="stable"):
        a, b, radius = capsules[k, [right, up]] + offset, capsules[k, [right + 3, up + 3]] + offset, capsules[k, 6]
        skin = SEGMENTS[k].endswith(("head", "neck", "hand", "forearm"))
        colour = np.array(SKIN if skin else COLOURS[int(BODY_PART[k])])
        if SEGMENTS[k].startswith("left"):
            colour = colour * 0.72
        axes.add_patch(Polygon(stadium(a, b, radius), facecolor=colour, edgecolor="black", linewidth=0.35, zorder=3))


def stadium(a: NDArray[np.float64], b: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """The outline of a capsule seen from anywhere."""
    along = np.arctan2(b[1] - a[1], b[0] - a[0])
    half = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 16)
    front = b + radius * np.column_stack([np.cos(along + half), np.sin(along + half)])
    back = a + radius * np.column_stack([np.cos(along + np.pi + half), np.sin(along + np.pi + half)])
    return np.concatenate([front, back])


def people(x: object, y: object, vx: object, vy: object, heading: object, phase: object) -> NDArray[np.float64]:
    """(N, 17, 7) capsules of N people of one stature."""
    columns = np.broadcast_arrays(*(np.asarray(c, np.float64) for c in (x, y, vx, vy, heading, phase)))
    x, y, vx, vy, heading, phase = (np.atleast_1d(c).copy() for c in columns)
    return pose(np.column_stack([x, y]), np.column_stack([vx, vy]), heading, np.full(len(x), STATURE), phase)


def strip(axes: Axes, speed: float, view: str, spacing: float) -> None:
    """One cycle at `speed`, left to right; the frames are set apart for the eye."""
    phase = np.arange(FRAMES) / FRAMES
    for k, capsules in enumerate(people(0.0, 0.0, speed, 0.0, 0.0, phase)):
        draw(axes, capsules, view, (k * spacing, 0.0))
    axes.set_ylabel(f"{view}, {speed:g} m/s" if speed else f"{view}, standing")


def finish(axes: Axes, floor: bool, low: float, high: float, left: float, right: float) -> None:
    if floor:
        axes.axhline(0.0, color="0.5", linewidth=0.8, zorder=1)
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)


def turning(axes: Axes) -> None:
    """A walk along a circle, from above, with the soles that stand on the floor at each frame."""
    speed, radius, dt, count = 1.2, 2.5, 0.05, 240
    rate = phase_rate(speed, STATURE)
    t = dt * np.arange(count)
    angle = speed * t / radius
    frames = people(
        radius * np.sin(angle), -radius * np.cos(angle), speed * np.cos(angle), speed * np.sin(angle), angle, rate * t
    )
    for capsules in frames:
        for foot in capsules[:2]:
            if min(foot[2], foot[5]) <= foot[6] + 1e-9:
                axes.plot(foot[[0, 3]], foot[[1, 4]], color="0.75", linewidth=3.0, solid_capstyle="round", zorder=1)
    for capsules in frames[::29]:
        draw(axes, capsules, "top")
    axes.set_ylabel("top, on a circle, 1.2 m/s")


def main() -> None:
    figure, axes = plt.subplots(7, 1, figsize=(11.0, 17.0), height_ratios=[2, 2, 2, 2, 1.0, 2, 5.6])
    width = (FRAMES - 1) * 1.25
    for row, speed in zip(axes[:3], (1.34, 0.4, 1.9), strict=True):
        strip(row, speed, "side", 1.25)
        finish(row, True, -0.05, 1.85, -0.9, width + 0.9)
    strip(axes[3], 1.34, "front", 1.25)
    finish(axes[3], True, -0.05, 1.85, -0.9, width + 0.9)
    strip(axes[4], 1.34, "top", 1.25)
    finish(axes[4], False, -0.45, 0.45, -0.9, width + 0.9)
    standing = [(0.0, 0.0, 0.1, "side"), (0.0, 0.0, 0.1, "front"), (0.0, 0.0, 0.6, "front")]
    back = [(-0.6, 0.0, phase, "side") for phase in (0.1, 0.35, 0.6)]
    aside = [(0.0, 0.3, phase, "front") for phase in (0.0, 0.3, 0.6)]
    for k, (vx, vy, phase, view) in enumerate(standing + back + aside):
        draw(axes[5], people(0.0, 0.0, vx, vy, 0.0, phase)[0], view, (k * 1.25, 0.0))
    axes[5].set_ylabel("standing, back, aside")
    finish(axes[5], True, -0.05, 1.85, -0.9, width + 0.9)
    turning(axes[6])
    finish(axes[6], False, -3.0, 3.0, -5.0, 5.0)
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("avatar.png"), dpi=80)


if __name__ == "__main__":
    main()
