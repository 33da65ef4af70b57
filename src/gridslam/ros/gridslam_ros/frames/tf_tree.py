"""Which frame hangs on which in TF, and what lacks between two frames."""

from __future__ import annotations

MADE_OF_SCANS = "lidar_odometry makes it of scans"


class TfTree:
    """Frames and their parents. A frame has one parent in TF, but two publishers may tell two.

    Then the parent counts that leads to the odometry's frame; if none does, or both, the one heard first.

    Args:
        odom_frame: the odometry's frame, the root that SLAM needs.
    """

    def __init__(self, odom_frame: str) -> None:
        self._odom_frame = odom_frame
        self._parents: dict[str, list[str]] = {}
        self._chosen: dict[str, str] = {}

    def parent_of(self, frame: str) -> str | None:
        """Return the parent that counts; None: TF does not tell any."""
        return self._chosen.get(frame)

    def add(self, parent: str, child: str) -> list[str]:
        """Take in an edge. Return the frames whose parent is another one from now on."""
        parents = self._parents.setdefault(child, [])
        if parent in parents:
            return []
        parents.append(parent)
        before = dict(self._chosen)
        self._chosen = {frame: self._choice(told) for frame, told in self._parents.items()}
        return [frame for frame, was in before.items() if self._chosen[frame] != was]

    def _choice(self, parents: list[str]) -> str:
        return next((parent for parent in parents if self._leads(parent, set())), parents[0])

    def _leads(self, frame: str, seen: set[str]) -> bool:
        if frame == self._odom_frame:
            return True
        seen.add(frame)
        parents = self._parents.get(frame, ())
        return any(self._leads(parent, seen) for parent in parents if parent not in seen)

    def root_of(self, frame: str) -> str:
        """Return the frame on which a frame hangs at last; itself, if it hangs on none."""
        seen = {frame}
        while frame in self._chosen and self._chosen[frame] not in seen:
            frame = self._chosen[frame]
            seen.add(frame)
        return frame

    def what_lacks(self, base_frame: str, lidar_frame: str) -> str:
        """Return what lacks between odometry, base and lidar, and what to do; empty if nothing does."""
        odom_frame = self._odom_frame
        base_root, lidar_root = self.root_of(base_frame), self.root_of(lidar_frame)
        if not self._parents:
            return (
                f"no TF has come at all; SLAM needs odometry ({MADE_OF_SCANS}) and the lidar's mounting there"
            )
        if not lidar_frame:
            return "the scans have no frame_id; the driver must set it to the lidar's frame in TF"
        if base_root != odom_frame and base_root != base_frame:
            return (
                f'odometry lacks: "{base_frame}" hangs on "{base_root}", not on "{odom_frame}"; '
                f"set odom_frame:={base_root}, or let TF have one root"
            )
        if base_root != odom_frame:
            below = self._below(odom_frame)
            what = "odometry" if below else f"odometry ({MADE_OF_SCANS})"
            return (
                f'odometry lacks: no transform from "{odom_frame}" to "{base_frame}" has come{below}; '
                f"send {what}, or set base_frame:=... and odom_frame:=... if the frames have other names"
            )
        if lidar_root == lidar_frame:
            return (
                f'the lidar\'s mounting lacks: no transform from "{base_frame}" to "{lidar_frame}" has come; '
                "check /tf_static, which a bag that was cut has lost"
            )
        if lidar_root != odom_frame:
            return (
                f'TF has two roots: "{lidar_frame}" hangs on "{lidar_root}", and "{base_frame}" on '
                f'"{odom_frame}"; send a transform that joins them'
            )
        return ""

    def _below(self, odom_frame: str) -> str:
        children = sorted(child for child, parent in self._chosen.items() if parent == odom_frame)
        names = ", ".join(f'"{child}"' for child in children)
        return f' (below "{odom_frame}" is {names})' if children else ""
