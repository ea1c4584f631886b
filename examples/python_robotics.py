"""A function with the signature of PythonRobotics' dynamic window approach; put yours here, or theirs.

It tries arcs that the robot can drive from now on, and takes the one that ends nearest to the goal without coming near
to anything.
"""

import numpy as np


class Config:
    """The robot's values are written into the fields of these names."""

    dt = 0.1
    max_speed = 1.0
    max_accel = 0.5
    max_yaw_rate = 1.0
    robot_radius = 0.3
    predict_time = 2.0


config = Config()


def avoid(x, config, goal, ob):
    """x = [x, y, yaw, v, omega], goal = [x, y], ob = [[x, y], ...] -> [v, omega], trajectory."""
    times = np.arange(config.dt, config.predict_time, config.dt)
    change = config.max_accel * config.dt
    best = (np.inf, [max(0.0, x[3] - change), 0.0], x[None, :3])
    for v in np.linspace(max(0.0, x[3] - change), min(config.max_speed, x[3] + change), 3):
        for omega in np.linspace(-config.max_yaw_rate, config.max_yaw_rate, 11):
            yaw = x[2] + omega * times
            way = np.cumsum(v * config.dt * np.column_stack([np.cos(yaw), np.sin(yaw)]), axis=0) + x[:2]
            gap = np.hypot(*(way[:, None] - ob).transpose(2, 0, 1)).min() - config.robot_radius
            if gap > 0.0:
                cost = np.hypot(*(goal - way[-1])) + 0.2 / gap
                best = min(best, (cost, [v, omega], np.column_stack([way, yaw])), key=lambda choice: choice[0])
    return best[1:]
