"""When the last views of an exploration show so little that it ends."""

from __future__ import annotations

from collections import deque

from exploration.next_view.explorer import Decision

SMALL_SHARE = 0.001
"""Of the known volume: less than this does not matter."""
WINDOW_S = 30.0
"""For so long the UAV has flown to views of layers only."""


class LastViews:
    """Watches what the views of layers show, to which the UAV flies when neither border nor room is left.

    Each of them may show a little more, so that a flight in a large place goes on for minutes.
    """

    def __init__(self) -> None:
        self._known_m3: deque[tuple[float, float]] = deque()
        """Time in s and known volume, since the last other view, or for a little more than the window."""

    def too_little_gain(self, stamp_s: float, known_m3: float, decision: Decision) -> str:
        """Take a decision. Return why it is not worth its flight, in a sentence; empty: it is."""
        if decision.goal_m is not None and not decision.is_of_layers:
            self._known_m3.clear()
            return ""
        self._known_m3.append((stamp_s, known_m3))
        while len(self._known_m3) > 1 and self._known_m3[1][0] <= stamp_s - WINDOW_S:
            self._known_m3.popleft()
        since_s, before_m3 = self._known_m3[0]
        won_m3, least_m3 = known_m3 - before_m3, SMALL_SHARE * known_m3
        is_worth = max(won_m3, decision.gain_m3) >= least_m3
        if not decision.is_of_layers or stamp_s - since_s < WINDOW_S or is_worth:
            return ""
        return (
            f"The views of the last {stamp_s - since_s:.0f} s have shown {max(won_m3, 0.0):.1f} m3 more, and "
            f"the next one would show {decision.gain_m3:.1f} m3: both are less than {SMALL_SHARE:.1%} of the "
            f"{known_m3:.0f} m3 that are known."
        )
