"""Static and moving frames of an SDF model, by its joint states (thesis, 9.2.4)."""

from __future__ import annotations

from typing import Iterable, Mapping

from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.frames import model_frames, root_link
from simulation_tools.transforms.edge_pairing import Edge


class JointFrames:
    """The frames of one model as edges for /tf_static and /tf.

    A joint's frame is in `static_edges`, at zero, until a joint state names the joint. From then on it comes
    from `on_joint_states` only, because TF does not allow a frame to be both.
    """

    def __init__(
        self, model: Model, base_frame: str, prefix: str = "", moving: Iterable[str] = (), name: str = ""
    ) -> None:
        """Begin. base_frame: TF name of the model frame. prefix: goes before all other names.

        moving: names of joints that are moving from the start, because their states will surely come. name:
        of the model in joint states that call a joint `model::joint`; empty: the one in the SDF.
        """
        self._root = root_link(model)
        self._frames = model_frames(model)
        self._base_frame, self._prefix = base_frame, prefix
        self._scope = f"{name or model.name}::"
        self._joints = {frame.joint.name for frame in self._frames if frame.joint is not None}
        self.moving = self._joints & set(moving)
        self._newest_ns = -1

    def static_edges(self) -> list[Edge]:
        """Return every static frame, parents before children."""
        edges = [Edge(0, self._base_frame, self._prefix + self._root.name, self._root.pose)]
        for frame in self._frames:
            if frame.joint is None or frame.joint.name not in self.moving:
                edges.append(Edge(0, self._prefix + frame.parent, self._prefix + frame.child, frame.pose))
        return edges

    def on_joint_states(self, stamp_ns: int, angles_rad: Mapping[str, float]) -> list[Edge]:
        """Take the angles of joints, called `joint` or `model::joint`; return the edges that turned.

        If `moving` has grown, the caller must publish `static_edges` again. Each stamp is used once. A stamp
        older than the newest means that the clock jumped back.
        """
        if stamp_ns == self._newest_ns:
            return []
        angles = {
            name[len(self._scope) :] if name.startswith(self._scope) else name: angle
            for name, angle in angles_rad.items()
        }
        angles = {name: angle for name, angle in angles.items() if name in self._joints}
        if not angles:
            return []
        self._newest_ns = stamp_ns
        self.moving = self.moving | set(angles)
        return [
            Edge(
                stamp_ns,
                self._prefix + frame.parent,
                self._prefix + frame.child,
                frame.at_angle(angles[frame.joint.name]),
            )
            for frame in self._frames
            if frame.joint is not None and frame.joint.name in angles
        ]
