"""Which transforms `tf_publisher` sends, and when: the pairing of odometry and ground truth by stamp.

`base_frame` may have one parent only, so the ground truth goes out as its inverse, `base_frame` -> `world`, in the
same message and with the same stamp as `odom` -> `base_frame` (DESIGN, section 2). The two arrive as separate ROS
messages, in either order; either source may be missing (no odometry running, or a real UAV without ground truth).
"""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.geometry import Pose

ABSENT_AFTER_NS = 500_000_000
"""A source that has said nothing for this long is not waited for."""


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
    """Pairs odometry and ground truth of one stamp; each call returns the edges that are due now, often none.

    A stamp is published at most once and stamps only rise, because tf2 rejects repeated ones.
    """

    def __init__(self, frames: FrameNames | None = None):
        self._frames = frames or FrameNames()
        self.clear()

    def clear(self) -> None:
        """Forgets everything, as after a jump of the clock."""
        self._waiting: dict[str, tuple[int, Edge]] = {}
        self._heard_ns = {"odometry": None, "ground_truth": None}
        self._published_ns = -1

    def on_odometry(self, stamp_ns: int, base_in_odom: Pose) -> list[Edge]:
        """Takes the UAV's pose in the odometry frame."""
        edge = Edge(stamp_ns, self._frames.odom, self._frames.base, base_in_odom)
        return self._on_edge("odometry", "ground_truth", edge)

    def on_ground_truth(self, stamp_ns: int, base_in_world: Pose) -> list[Edge]:
        """Takes the UAV's true pose in the world frame."""
        edge = Edge(stamp_ns, self._frames.base, self._frames.world, base_in_world.inverse())
        return self._on_edge("ground_truth", "odometry", edge)

    def _on_edge(self, source: str, other: str, edge: Edge) -> list[Edge]:
        stamp_ns = edge.stamp_ns
        self._heard_ns[source] = stamp_ns
        if stamp_ns <= self._published_ns:
            return []
        unpaired = self._waiting.get(source)
        partner = self._waiting.get(other)
        if partner is not None and partner.stamp_ns == stamp_ns:
            return self._publish([edge, partner])
        if self._is_absent(other, stamp_ns):
            return self._publish([edge])
        self._waiting[source] = edge
        # Its partner of the stamp before never came: late is better than never.
        return self._publish([unpaired], keep=edge) if unpaired is not None else []

    def _is_absent(self, source: str, now_ns: int) -> bool:
        heard_ns = self._heard_ns[source]
        return heard_ns is None or now_ns - heard_ns > ABSENT_AFTER_NS

    def _publish(self, edges: list[Edge], keep: Edge | None = None) -> list[Edge]:
        newest_ns = max(edge.stamp_ns for edge in edges)
        self._published_ns = newest_ns
        self._waiting = {
            source: waiting for source, waiting in self._waiting.items() if waiting.stamp_ns > newest_ns
        }
        return edges
