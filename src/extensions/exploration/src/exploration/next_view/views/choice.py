"""Ways to choose the next best view: an interface, and the ways that there are.

A way of one's own is one class and one entry of `VIEW_CHOICES`: CONTRIBUTING.md, "How to add".
"""

from __future__ import annotations

from typing import Callable, Mapping, Protocol

import numpy as np

from exploration.next_view.frontiers import Frontiers
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.views.border import BorderViews
from exploration.next_view.views.revealing import RevealingViews
from exploration.next_view.views.scene import Scene
from exploration.next_view.views.view import Look, View
from exploration.planning.space import Space
from flight_basics.errors import ParameterError


class ViewChoice(Protocol):
    """Chooses the next best view. The explorer calls `note` with each decision, and then `best`."""

    def note(self, scene: Scene, looked: Look) -> None:
        """Take what the UAV looked at since the last decision."""

    def best(
        self, scene: Scene, roadmap: Roadmap, nodes: np.ndarray, here_m: np.ndarray, present: View | None
    ) -> View | None:
        """Return the view that is worth most for its time; None: none is worth it.

        Args:
            scene: the map. `note` was called with it.
            roadmap: the ways from the UAV.
            nodes: (n,) of the roadmap that are looked from.
            here_m: (x, y, z) of the UAV in the map's frame.
            present: the view that the UAV flies to. It is kept unless another is worth `keep` times more.
        """

    def is_left(self, scene: Scene, cells: Frontiers) -> np.ndarray:
        """Return (m,) whether cells of the border, of the side `cell`, were looked at without gain."""

    def news_voxels(self, space: Space) -> float:
        """Return how many voxels must be new before a view may be worth it again."""


VIEW_CHOICES: Mapping[str, Callable[[ExplorerParameters, bool], ViewChoice]] = {
    "border": lambda parameters, is_steep: BorderViews(parameters),
    "volume": RevealingViews,
}
"""Each makes one from the parameters, and from whether views may lie straight above and below."""


def view_choice(parameters: ExplorerParameters, is_steep: bool) -> ViewChoice:
    """Return the way that `view_choice` of the parameters names.

    Raises:
        ParameterError: there is none of that name.
    """
    make = VIEW_CHOICES.get(parameters.view_choice)
    if make is None:
        raise ParameterError(
            f"view_choice is '{parameters.view_choice}'; it must be one of {', '.join(sorted(VIEW_CHOICES))}."
        )
    return make(parameters, is_steep)
