"""What an errand asks of whoever decides: an exploration, a survey's photographs, a mission."""

from __future__ import annotations

from typing import Any, Mapping, NamedTuple, Protocol, Sequence

import numpy as np

from flight_basics.pose.trust import Trust


class Here(NamedTuple):
    """Where the UAV is. time_s: of a clock that nobody sets. stamp_s: of the message. more: as in `Pose`.

    deviation_m: standard deviation of the place, beside what its message tells. silent_s: no pose has come
    for so long, so the UAV is somewhere else now; 0: the place is that of this instant.
    """

    time_s: float
    stamp_s: float
    place_m: np.ndarray
    more: Any = None
    deviation_m: float = 0.0
    silent_s: float = 0.0


class Outcome(NamedTuple):
    """How a flight has ended. end: of its action: succeeded, aborted or canceled. words: why.

    must_land: the UAV is not home, and must land where it is. log: what the log says.
    """

    words: str
    end: str = "succeeded"
    must_land: bool = False
    log: str = ""


class Leader(Protocol):
    """Decides where a UAV flies.

    Two threads call it. The worker's calls `prepare`, `look` and `rest`, and may need seconds. The errand's
    calls all others meanwhile, and each of them returns soon.

    Attributes:
        setpoint: where to fly; None: nowhere yet. Another object is a new setpoint.
        kept: what a node that dies in flight must find again, as `begin` takes it.
        end: why it has ended, in a word; empty: it flies. reason: the same in a sentence.
        is_paused: it hovers until it is resumed. is_busy: in lockstep the simulator waits for it.
        has_map: the map is there; without one nobody flies.
    """

    @property
    def setpoint(self) -> Any: ...  # noqa: D102
    @property
    def kept(self) -> Mapping[str, Any]: ...  # noqa: D102
    @property
    def end(self) -> str: ...  # noqa: D102
    @property
    def reason(self) -> str: ...  # noqa: D102
    @property
    def is_paused(self) -> bool: ...  # noqa: D102
    @property
    def is_busy(self) -> bool: ...  # noqa: D102
    @property
    def has_map(self) -> bool: ...  # noqa: D102

    def prepare(self, content: Any) -> Any:
        """Read what a goal names, in the worker's thread.

        Raises:
            FlightBasicsError: it cannot be flown, in one sentence.
        """

    def begin(self, plan: Any, here: Here | None, kept: Mapping[str, Any] | None) -> str:
        """Begin what `prepare` returned; no look is under way. Return a sentence for the log.

        kept: of the node that died while it flew this goal. It holds only `home` if the goal before this one
        is still flown. None: a flight begins.

        Raises:
            FlightBasicsError: it cannot be flown, in one sentence.
        """

    def note(self, here: Here) -> None:
        """Take where the UAV is, also while nothing is flown."""

    def follow(self, here: Here) -> bool:
        """Follow the way. Return whether it is time to `look`."""

    def look(self, here: Here, readings: Sequence[tuple[float, float]]) -> list[str]:
        """Decide, in the worker's thread. Return what is wrong, in sentences. readings: of the battery.

        While no pose comes (`here.silent_s`), only time and battery count.
        """

    def rest(self) -> None:
        """Do what is to be done while nothing is flown, in the worker's thread."""

    def trust(self, trust: Trust, why: str, here: Here) -> None:
        """Take what the pose is good for. why: it is not sure."""

    def pause(self, here: Here) -> None:
        """Hover here until `resume` or `abort`."""

    def resume(self) -> None:
        """Go on after a pause."""

    def abort(self, reason: str) -> None:
        """End what is flown as soon as may be: come home, or stay where the UAV is."""

    def strand(self, why: str, here: Here | None) -> None:
        """End here, because the UAV cannot come home. here: its last place; None: in no frame any more."""

    def give_way(self) -> None:
        """Fly what is best until another goal begins, which has just come."""

    def stop_waiting(self) -> str:
        """End what goes on while nothing is flown. Return it in a sentence; empty: nothing goes on."""

    def outcome(self) -> Outcome | None:
        """Return how the flight has ended; None: it has not."""
