"""Who walks there: the populations of a crowd, and the people of one episode, drawn with the seed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from components.crowd.distributions import Bell, Distribution, Normal, bounds, draw, require_positive
from components.crowd.policies import PolicyName
from components.crowd.reactions import Reaction
from components.crowd.steering import Recipe
from components.crowd.variants import VARIANTS

Array = NDArray[np.float64]
Rng = Callable[[int], np.random.Generator]

PLACES, SPEEDS, BODIES, STEPS, CHOICES, POPULATIONS, HORIZONS, RADII, STATURES, TOP_SPEEDS, ACCELERATIONS = range(11)
VARIANT, PARTIES = 11, 12
"""streams of chance: a change in one property leaves the others as they are; populations have PARTIES + index"""

STATURE = np.array([[1.759, 0.070], [1.618, 0.065]])
"""median and standard deviation of men's and women's body height [m]"""
BODY_MASS_INDEX = 25.0
"""median [kg/m2]; a choice between the mean of adults of the world, 24, and of richer countries, 26 to 28"""
BODY_MASS_SPREAD = 0.15
"""standard deviation of the logarithm of the body mass index: two of three adults within 21.5 and 29 kg/m2"""


WALKING = Normal(normal=Bell(mean=1.3, deviation=0.2, limits=(0.8, 1.8)))
"""speeds of the paper's crowd [m/s]"""


@dataclass(frozen=True, kw_only=True)
class Traits:
    """What people are like.

    A `Distribution` is a number for all, a list with one for each, `{uniform: [...]}` or `{normal: {...}}`.
    """

    policy: PolicyName | Recipe = "orca"
    """how people avoid each other: a shipped policy, or costs and an optimiser of your own"""
    time_horizon: Distribution = 1.5
    """of `orca`: collisions later than this are ignored [s]"""
    reaction: Reaction = "person"
    """how people react to robots"""
    groups: tuple[float, ...] = (1.0,)
    """shares of the people who walk alone, in pairs, in threes and so on"""
    preferred_speed: Distribution = WALKING
    """speeds that people walk at when they are free [m/s]"""
    max_speed: Distribution = 1.8
    """speeds that people do not want to exceed [m/s]"""
    max_acceleration: Distribution = 5.0
    """as hard as people want to accelerate or brake at most [m/s2]"""
    radius: Distribution = 0.3
    """radii of the bodies' discs [m]"""
    stature: Distribution | None = None
    """body heights [m]; by default those of adults, half of them men"""

    def __post_init__(self) -> None:
        for name in ("time_horizon", "preferred_speed", "max_speed", "max_acceleration", "radius", "stature"):
            if (value := getattr(self, name)) is not None:
                require_positive(name, value)
        fastest, limit = bounds(self.preferred_speed)[1], bounds(self.max_speed)[0]
        if fastest > limit:
            raise ValueError(f"preferred_speed may be {fastest}, expected at most max_speed ({limit})")
        shares = self.groups
        if not (shares and min(shares) >= 0 and 0 < sum(shares) < math.inf):
            raise ValueError(f"groups is {list(shares)}, expected shares of which one at least is positive")


@dataclass(frozen=True, kw_only=True)
class Population:
    """A part of the crowd: what it does not say is as for everybody."""

    name: str
    """what they are called, such as `elderly`"""
    share: float
    """how many of them, in proportion to the other shares"""
    policy: PolicyName | Recipe | None = None
    """how they avoid others"""
    time_horizon: Distribution | None = None
    """of `orca`: collisions later than this are ignored [s]"""
    reaction: Reaction | None = None
    """how they react to robots"""
    groups: tuple[float, ...] | None = None
    """shares of them who walk alone, in pairs, in threes and so on"""
    preferred_speed: Distribution | None = None
    """speeds that they walk at when they are free [m/s]"""
    max_speed: Distribution | None = None
    """speeds that they do not want to exceed [m/s]"""
    max_acceleration: Distribution | None = None
    """as hard as they want to accelerate or brake at most [m/s2]"""
    radius: Distribution | None = None
    """radii of their discs [m]"""
    stature: Distribution | None = None
    """body heights [m]"""

    def __post_init__(self) -> None:
        if not (self.share > 0 and math.isfinite(self.share)):
            raise ValueError(f"share is {self.share}, expected a positive number")

    def traits(self, crowd: Traits) -> Traits:
        """What they are like, given what the crowd is like.

        Raises:
            ValueError: if both do not go together.
        """
        own = {f.name: getattr(self, f.name) for f in fields(Traits) if getattr(self, f.name) is not None}
        try:
            return Traits(**({f.name: getattr(crowd, f.name) for f in fields(Traits)} | own))
        except ValueError as error:
            raise ValueError(f"populations: '{self.name}': {error}") from None


@dataclass(frozen=True, kw_only=True)
class People:
    """The N people of one episode; all arrays have one entry for each."""

    population: NDArray[np.int64]
    """index of the population"""
    variant: NDArray[np.int64]
    """number of the variant of the population's policy, where people differ in its options"""
    group: NDArray[np.uint32]
    """number of the social group, from 1; 0: alone"""
    time_horizon: Array
    """[s]"""
    preferred_speed: Array
    """[m/s]"""
    max_speed: Array
    """[m/s]"""
    max_acceleration: Array
    """[m/s2]"""
    radius: Array
    """[m]"""
    stature: Array
    """[m]"""
    mass: Array
    """[kg]"""
    party: NDArray[np.int64]
    """index of those who walk together, or of one who walks alone, by the first of them"""


def draw_people(rng: Rng, count: int, populations: Sequence[tuple[str, float, Traits]]) -> People:
    """`count` people of populations given by name, share and traits.

    Raises:
        ValueError: if a list of values does not have one for each.
    """
    population = draw_shares(rng(POPULATIONS), count, [share for _, share, _ in populations])
    members = [np.flatnonzero(population == p) for p in range(len(populations))]

    def drawn(trait: str, stream: int) -> Array:
        values = np.empty(count)
        for (name, _, traits), who in zip(populations, members, strict=True):
            try:
                values[who] = draw(getattr(traits, trait), rng(stream), count, who)
            except ValueError as error:
                raise ValueError(f"{trait}{f' of {name}' if name else ''} is {error}") from None
        return values

    stature, mass = _draw_bodies(rng, count, populations, members)
    leader = np.empty(count, np.int64)
    for p, ((_, _, traits), who) in enumerate(zip(populations, members, strict=True)):
        leader[who] = who[_leaders(rng(PARTIES + p), len(who), traits.groups)]
    _, party, size = np.unique(leader, return_inverse=True, return_counts=True)
    number = np.where(size > 1, np.cumsum(size > 1), 0)
    pace = drawn("preferred_speed", SPEEDS)
    if (size > 1).any():
        # Those who walk together have one pace.
        pace = (np.bincount(party, pace) / size)[party]
    return People(
        population=population,
        variant=rng(VARIANT).integers(0, VARIANTS, count),
        group=number[party].astype(np.uint32),
        time_horizon=drawn("time_horizon", HORIZONS),
        preferred_speed=pace,
        max_speed=drawn("max_speed", TOP_SPEEDS),
        max_acceleration=drawn("max_acceleration", ACCELERATIONS),
        radius=drawn("radius", RADII),
        stature=stature,
        mass=mass,
        party=party,
    )


def draw_shares(rng: np.random.Generator, count: int, shares: Sequence[float]) -> NDArray[np.int64]:
    """(count,) index of everybody's share, in random order; the sizes are as near to the shares as whole people are."""
    edges = np.rint(np.cumsum(shares) / np.sum(shares) * count).astype(np.int64)
    return rng.permutation(np.repeat(np.arange(len(shares)), np.diff(edges, prepend=0)))


def draw_bodies(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """(count,) statures [m] and masses [kg] of adults, half of them men: normal, and log-normal body mass indices."""
    median, deviation = STATURE[rng.integers(0, 2, count)].T
    stature = rng.normal(median, deviation)
    index = rng.lognormal(np.log(BODY_MASS_INDEX), BODY_MASS_SPREAD, count)
    return stature, index * stature**2


def _draw_bodies(
    rng: Rng,
    count: int,
    populations: Sequence[tuple[str, float, Traits]],
    members: Sequence[NDArray[np.int64]],
) -> tuple[Array, Array]:
    """Bodies of adults, with other statures where those are given."""
    stature, mass = draw_bodies(rng(BODIES), count)
    for (_, _, traits), who in zip(populations, members, strict=True):
        if traits.stature is not None:
            given = draw(traits.stature, rng(STATURES), count, who)
            mass[who] *= (given / stature[who]) ** 2
            stature[who] = given
    return stature, mass


def _leaders(rng: np.random.Generator, count: int, shares: Sequence[float]) -> NDArray[np.int64]:
    """(count,) index of the first of those with whom each walks, neighbours in the list.

    As many groups of each size as whole groups come near to the share of people in them; the rest walk alone.
    """
    sizes: list[int] = []
    for size in range(len(shares), 1, -1):
        wanted = shares[size - 1] / sum(shares) * count
        groups = min(round(wanted / size), (count - sum(sizes)) // size)
        sizes += [size] * groups
    if not sizes:
        return np.arange(count)
    sizes += [1] * (count - sum(sizes))
    lengths = rng.permutation(sizes)
    return np.repeat(np.cumsum(lengths) - lengths, lengths)
