"""Whether the flight controller brings the UAV down without an order of ours, and what it says about it."""

from __future__ import annotations

from typing import NamedTuple

DESCENDING = frozenset(("AUTO.LAND", "AUTO.RTL", "AUTO.PRECLAND", "LAND", "RTL", "SMART_RTL"))
"""Modes, by MAVROS's names, that end on the ground."""
SEVERE = 4
"""MAV_SEVERITY_WARNING; smaller is worse."""
TOGETHER_S = 5.0
"""What the flight controller says within this time before a change of mode belongs to it, or after it."""


class Said(NamedTuple):
    """A message of the flight controller to people: STATUSTEXT."""

    t_s: float
    text: str


class OwnDescent:
    """Hears the flight controller's mode, charge and messages. Times: any clock, the same for all, s.

    Attributes:
        mode: in which it descends now; empty: it does not.
    """

    def __init__(self) -> None:
        self.mode = ""
        self._since_s = 0.0
        self._said: Said | None = None
        self._reason = ""
        self._charge: float | None = None

    def on_mode(self, t_s: float, mode: str) -> None:
        """Note the mode. A message that is much older is of no interest then."""
        was, self.mode = self.mode, mode if mode in DESCENDING else ""
        if self.mode and not was:
            self._since_s = t_s
            if self._said is not None and t_s - self._said.t_s > TOGETHER_S:
                self._said = None

    def on_text(self, t_s: float, severity: int, text: str) -> None:
        """Note a message. Messages that come long after the change of mode do not explain it."""
        if severity <= SEVERE and not (self.mode and t_s - self._since_s > TOGETHER_S):
            self._said = Said(t_s, text.strip())

    def on_reason(self, reason: str) -> None:
        """Note why mavros_publisher takes no commands; empty: it does. Later reasons explain nothing."""
        if not self.mode:
            self._reason = reason

    def on_charge(self, charge: float) -> None:
        """Note the battery's charge, 0..1; anything else is none."""
        self._charge = charge if 0.0 <= charge <= 1.0 else None

    @property
    def sentence(self) -> str:
        """Why the UAV comes down, as far as it was told; empty: it does not."""
        if not self.mode:
            return ""
        words = [f"The UAV came down in {self.mode}, which this run had not ordered"]
        if self._reason:
            words.append(f"before: {self._reason}")
        if self._said is not None:
            words.append(f'the flight controller said "{self._said.text}"')
        if self._charge is not None:
            words.append(f"its battery was at {self._charge:.0%}")
        return f"{'; '.join(words)}."
