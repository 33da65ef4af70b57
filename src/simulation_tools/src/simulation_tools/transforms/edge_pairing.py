"""The transforms of `tf_publisher`: pairs odometry and ground truth by stamp.

In TF `base_frame` may have one parent only. So the ground truth is published as its inverse, `base_frame` ->
`world`, in the same message and with the same stamp as `odom` -> `base_frame`. The two arrive as separate
ROS messages in any order. Either source may be missing (no odometry, or a real UAV without ground truth).
"""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.geometry import Pose

ABSENT_AFTER_NS = 500_000_000
"""After this time without a message the other source does not wait for this one."""


@dataclass(frozen=True)
class FrameNames:
    """The frames that `tf_publisher` connects."""

    odom: str = "odom"
    base: str = "base_frame"
    world: str = "world"


@dataclass(frozen=True)
class Edge:
    """A transform to publish: the pose of `child` in `parent` at `stamp_ns`."""

    stamp_ns: int
    parent: str
    child: str
    pose: Pose


class EdgePairer:
    """Pairs odometry and ground truth of one stamp.

    Each call returns the edges that are due, often none. A stamp is published at most once, and stamps only
    rise, because tf2 rejects repeated ones. If a source's stamps go back (reset, bag loop), the class
    forgets everything and counts it in `jumps_back`.
    """

    def __init__(self, frames: FrameNames | None = None):
        self._frames = frames or FrameNames()
        self.jumps_back = 0
        self._forget()

    def on_odometry(self, stamp_ns: int, base_in_odom: Pose) -> list[Edge]:
        """Take the UAV's pose in the odometry frame."""
        edge = Edge(stamp_ns, self._frames.odom, self._frames.base, base_in_odom)
        return self._on_edge("odometry", "ground_truth", edge)

    def on_ground_truth(self, stamp_ns: int, base_in_world: Pose) -> list[Edge]:
        """Take the UAV's true pose in the world frame."""
        edge = Edge(stamp_ns, self._frames.base, self._frames.world, base_in_world.inverse())
        return self._on_edge("ground_truth", "odometry", edge)

    def _forget(self) -> None:
        self._waiting: dict[str, Edge] = {}
        self._heard_ns: dict[str, int] = {}
        self._published_ns = -1

    def _on_edge(self, source: str, other: str, edge: Edge) -> list[Edge]:
        stamp_ns = edge.stamp_ns
        if stamp_ns < self._heard_ns.get(source, -1):
            self.jumps_back += 1
            self._forget()
        self._heard_ns[source] = stamp_ns
        if stamp_ns <= self._published_ns:
            return []
        partner = self._waiting.get(other)
        if partner is not None and partner.stamp_ns == stamp_ns:
            return self._publish(edge, partner)
        # The source's last edge, if its partner was lost, because one edge is better than none.
        unpaired = [
            old for old in (self._waiting.get(source),) if old is not None and old.stamp_ns < stamp_ns
        ]
        if stamp_ns - self._heard_ns.get(other, -ABSENT_AFTER_NS - 1) > ABSENT_AFTER_NS:
            return self._publish(*unpaired, edge)
        self._waiting[source] = edge
        return self._publish(*unpaired) if unpaired else []

    def _publish(self, *edges: Edge) -> list[Edge]:
        self._published_ns = edges[-1].stamp_ns
        self._waiting = {
            source: edge for source, edge in self._waiting.items() if edge.stamp_ns > self._published_ns
        }
        return list(edges)
