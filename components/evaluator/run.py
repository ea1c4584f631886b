"""One robot's run as a whole, and what a metric may require of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Invalid:
    """There is no such value in this run."""

    reason: str


@dataclass(frozen=True, kw_only=True)
class Run:
    """How long one robot was under way, whether it arrived, and what it is compared with."""

    steps: int
    """K, taken until then"""
    time: float
    """T, until it reached its goal, or until the end of the episode [s]"""
    arrived: bool
    """True if it reached its goal before the episode ended"""
    goal_distance: float
    """what was left at the end, as the crow flies: to the goal's line, or to its disc [m]"""
    alone: bool
    """True in the reference run, which has no people"""
    people: int
    """the largest number of people there were at a time"""
    reference: Mapping[str, float] | None
    """metric -> value of the same robot in the reference run, where one was made"""


def duration(run: Run) -> Invalid | None:
    """The run takes time: rates and shares of time divide by it."""
    return None if run.steps else Invalid(reason="the run has no duration: the robot starts at its goal")


def people(run: Run) -> Invalid | None:
    """There are people: without them, nothing is said about how the robot treats them."""
    if run.alone:
        return Invalid(reason="this is the reference run, without people")
    return None if run.people else Invalid(reason="there were no people")


def arrival(run: Run) -> Invalid | None:
    """The robot reached its goal: totals of half a journey do not compare with those of a whole one."""
    return None if run.arrived else Invalid(reason="the robot did not reach its goal")


def reference(run: Run) -> Invalid | None:
    """The same robot reached the same goal alone."""
    if run.alone:
        return Invalid(reason="this is the reference run itself")
    if run.reference is None:
        return Invalid(reason="there is no reference run without people to compare with")
    if "success" not in run.reference:
        return Invalid(reason="the reference run has no 'success'")
    return None if run.reference["success"] else Invalid(reason="the robot alone did not reach its goal")
