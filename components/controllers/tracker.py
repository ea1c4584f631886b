"""Following people from detection to detection: a Kalman filter for each, and the assignment that fits best.

    x' = x + dt v, v' = v + noise of the acceleration;  Q = q (dt^3/3, dt^2/2; dt^2/2, dt)
    z  = x + noise of the detection;  d^2 = |z - x|^2 / S,  S = P_xx + deviation^2

Both coordinates have equal variances, so that one 2 x 2 covariance per person is enough. Detections go to people such
that the sum of d^2 is least (Kuhn, "The Hungarian method for the assignment problem", Naval Research Logistics
Quarterly 2, 1955), none beyond the gate.

Bar-Shalom, Li, Kirubarajan, "Estimation with applications to tracking and navigation", Wiley 2001, section 6.2.2.

Not in the book: how long somebody unseen is believed to walk on, and what a newcomer's speed may be.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Array = NDArray[np.float64]

AGILITY = 0.5
"""q, spectral density of people's acceleration [m2/s3]"""
GATE = 13.8
"""d^2 beyond which a detection is somebody else's: 1 in 1000 of the right ones, for two coordinates"""
NEWCOMER = 1.3
"""standard deviation of each coordinate of a newcomer's velocity [m/s]"""
PATIENCE = 0.5
"""for how long somebody who is not detected is believed to walk on [s]"""
EXACT = 0.01
"""least standard deviation of a detection [m], [m/s]"""


class Tracker:
    """M people in a frame that does not move."""

    def __init__(self) -> None:
        self.position: Array = np.empty((0, 2))
        """(M, 2) [m]"""
        self.velocity: Array = np.empty((0, 2))
        """(M, 2) [m/s]"""
        self.radius: Array = np.empty(0)
        """(M,) as last reported [m]"""
        self._covariance: Array = np.empty((0, 2, 2))
        self._unseen: Array = np.empty(0)

    def predict(self, dt: float) -> None:
        """Let everybody walk on for dt [s], and forget whom nobody has seen for long."""
        kept = self._unseen <= PATIENCE
        self._take(np.flatnonzero(kept))
        self.position = self.position + dt * self.velocity
        F = np.array([[1.0, dt], [0.0, 1.0]])
        Q = AGILITY * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
        self._covariance = F @ self._covariance @ F.T + Q
        self._unseen = self._unseen + dt

    def correct(
        self, position: Array, position_deviation: Array, velocity: Array, velocity_deviation: Array, radius: Array
    ) -> None:
        """Take N detections into account.

        Args:
            position: (N, 2) where people were detected [m].
            position_deviation: (N,) standard deviation of each coordinate [m].
            velocity: (N, 2) how they were detected to move [m/s].
            velocity_deviation: (N,) of each coordinate; infinite where it is not known [m/s].
            radius: (N,) [m].
        """
        variance = np.maximum(position_deviation, EXACT) ** 2
        who, which = self._assign(position, variance)
        self._update(who, 0, position[which] - self.position[who], variance[which])
        known = np.isfinite(velocity_deviation[which])
        who_moves, moving = who[known], which[known]
        variance_v = np.maximum(velocity_deviation[moving], EXACT) ** 2
        self._update(who_moves, 1, velocity[moving] - self.velocity[who_moves], variance_v)
        self.radius[who], self._unseen[who] = radius[which], 0.0
        new = np.setdiff1d(np.arange(len(position)), which)
        fast = np.isfinite(velocity_deviation[new])
        deviation = np.where(fast, np.maximum(velocity_deviation[new], EXACT), NEWCOMER)
        self.position = np.concatenate([self.position, position[new]])
        self.velocity = np.concatenate([self.velocity, np.where(fast[:, None], velocity[new], 0.0)])
        self.radius = np.concatenate([self.radius, radius[new]])
        covariance = np.zeros((len(new), 2, 2))
        covariance[:, 0, 0], covariance[:, 1, 1] = variance[new], deviation**2
        self._covariance = np.concatenate([self._covariance, covariance])
        self._unseen = np.concatenate([self._unseen, np.zeros(len(new))])

    def _assign(self, position: Array, variance: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Whose detections are which: numbers of people, and of their detections."""
        d = position[None, :, :] - self.position[:, None, :]
        cost = (d**2).sum(axis=2) / (self._covariance[:, 0, 0, None] + variance[None, :])
        # A pair beyond the gate costs as much as leaving both alone.
        who, which = linear_sum_assignment(np.minimum(cost, GATE))
        near = cost[who, which] < GATE
        return who[near], which[near]

    def _update(self, who: NDArray[np.intp], part: int, innovation: Array, variance: Array) -> None:
        """The filter's gain on position (`part` 0) or velocity (1) as measured."""
        P = self._covariance[who]
        gain = P[:, :, part] / (P[:, part, part] + variance)[:, None]
        self.position[who] += gain[:, :1] * innovation
        self.velocity[who] += gain[:, 1:] * innovation
        self._covariance[who] = P - gain[:, :, None] * P[:, part, None, :]

    def _take(self, who: NDArray[np.intp]) -> None:
        self.position, self.velocity, self.radius = self.position[who], self.velocity[who], self.radius[who]
        self._covariance, self._unseen = self._covariance[who], self._unseen[who]
