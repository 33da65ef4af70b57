"""The beams of the lidars of the thesis's tables 8.2 and D.1, and of those for tanks."""

from __future__ import annotations

from gridslam.evaluation.volume.visibility import LidarView

PLANE_DEG = (-0.5, 0.5)
"""What a planar lidar's beams, which are not infinitely thin, count as seen."""

VIEWS = {
    "urg": LidarView(PLANE_DEG, 239.77, 5.6),
    "ust": LidarView(PLANE_DEG, 270.0, 10.0),
    "utm": LidarView(PLANE_DEG, 270.0, 30.0),
    "puck": LidarView((-15.0, 15.0), 360.0, 100.0),
    "near_puck": LidarView((-15.0, 15.0), 360.0, 100.0),
    "qt64": LidarView((-40.5, 52.1), 360.0, 60.0),
    "tim": LidarView(PLANE_DEG, 270.0, 25.0),
    "m8": LidarView((-17.0, 3.0), 360.0, 150.0),
}
