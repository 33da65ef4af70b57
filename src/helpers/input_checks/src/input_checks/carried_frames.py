"""Which frames of TF the UAV carries: a cloud in another frame does not tell where its lidar was."""

from __future__ import annotations

from typing import Sequence


class CarriedFrames:
    """The edges of TF between frames.

    The UAV carries what hangs on its body. The body is the base frame, and all above it up to the first edge
    that moves: some odometries tell where the lidar is, and the base hangs on the lidar.
    """

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, bool]] = {}
        """By child: the parent, and whether the edge is static."""

    def add(self, parent: str, child: str, is_static: bool) -> None:
        """Take in an edge."""
        self._parents[child.lstrip("/")] = parent.lstrip("/"), is_static

    def forget(self) -> None:
        """Forget the edges that move."""
        self._parents = {child: edge for child, edge in self._parents.items() if edge[1]}

    def lacks(self, base_frame: str, frame: str, worlds: Sequence[str] = ()) -> str:
        """Return a sentence if the UAV does not carry a frame; empty: it does, or TF does not tell (yet).

        worlds: frames that no UAV carries.
        """
        if frame not in worlds and not self._is_apart(base_frame, frame):
            return ""
        return (
            f'"{frame}" does not move with "{base_frame}", so what comes in it does not tell where its '
            "sensor was; let its source send it in the sensor's own frame."
        )

    def _is_apart(self, base_frame: str, frame: str) -> bool:
        above = [base_frame, *self._above(base_frame)]
        body = next((name for name in above if not self._parents.get(name, ("", True))[1]), None)
        beside = [frame, *self._above(frame)]
        is_known = frame in above or len(beside) > 1
        return body is not None and is_known and body not in beside

    def _above(self, frame: str) -> list[str]:
        """Return the frames above one, up to the root."""
        found: list[str] = []
        while frame in self._parents and self._parents[frame][0] not in found:
            frame = self._parents[frame][0]
            found.append(frame)
        return found
