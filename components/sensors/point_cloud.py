"""A scan as a point cloud: sensor_msgs/PointCloud2 with x, y, z, and who each point is on.

Frame and time are those of the scan (REP 103: x ahead, y left, z up; the points are level, z = 0). Beams without a
range give no point. Fields: x, y, z [m], float32; kind and body_part, uint8, and agent, uint32, as in `BeamAgents`.
"""

from __future__ import annotations

import numpy as np

from crowdcosim.component import Sensor
from crowdcosim.messages import BeamAgents, LaserScan, PointCloud2, PointField

_POINT = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("agent", "<u4"), ("kind", "u1"), ("body_part", "u1"), ("", "V2")]
)
_TYPES = {"<f4": PointField.FLOAT32, "<u4": PointField.UINT32, "|u1": PointField.UINT8}
_FIELDS = tuple(
    PointField(name=name, offset=offset, datatype=_TYPES[dtype.str], count=1)
    for name, (dtype, offset) in ((n, _POINT.fields[n][:2]) for n in ("x", "y", "z", "agent", "kind", "body_part"))
)


class PointCloud(Sensor):
    """Turns a LiDAR's scan into a point cloud."""

    def step(self, scan: LaserScan, agents: BeamAgents) -> PointCloud2:
        measured = np.flatnonzero(np.isfinite(scan.ranges))
        ranges = scan.ranges[measured].astype(np.float64)
        angles = scan.angle_min + scan.angle_increment * measured
        points = np.zeros(len(measured), _POINT)
        points["x"], points["y"] = ranges * np.cos(angles), ranges * np.sin(angles)
        points["agent"], points["kind"] = agents.agent[measured], agents.kind[measured]
        points["body_part"] = agents.body_part[measured]
        return PointCloud2(
            header=scan.header,
            height=1,
            width=len(points),
            fields=_FIELDS,
            is_bigendian=False,
            point_step=_POINT.itemsize,
            row_step=points.nbytes,
            data=points.view(np.uint8),
            is_dense=True,
        )
