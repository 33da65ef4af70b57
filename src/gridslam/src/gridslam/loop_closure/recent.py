"""What is made of the nodes of a path, and kept for those that were asked for last."""

from __future__ import annotations

from typing import Callable, Generic, TypeVar

Made = TypeVar("Made")


class Recent(Generic[Made]):
    """Makes something of a node when it is asked for. Memory does not grow with the path.

    A search asks for the nodes around the newest one, and around the place that it has come to. The next
    search asks for most of them again.

    Args:
        make: returns what is made of a node, the same each time.
        most: so many are kept.
    """

    def __init__(self, make: Callable[[int], Made], most: int) -> None:
        self._make, self._most = make, most
        self._kept: dict[int, Made] = {}
        """The one that was asked for last is the last one."""

    def __len__(self) -> int:
        return len(self._kept)

    def of(self, node: int) -> Made:
        """Return what is made of a node."""
        made = self._kept.pop(node, None)
        if made is None:
            made = self._make(node)
            if len(self._kept) >= self._most:
                del self._kept[next(iter(self._kept))]
        self._kept[node] = made
        return made
