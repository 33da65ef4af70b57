"""Pairs each message of a leading topic, such as a scan, with those of other topics that belong to it."""

from __future__ import annotations

from collections import deque
from typing import Any, NamedTuple

KEPT_MESSAGES = 64
KEPT_LEADERS = 8
KEPT_SHARED = 3
"""Of so many leaders in a row that had a source's message, the least distance tells how often one has."""

PATIENT_MESSAGES = 20_000
PATIENT_LEADERS = 2_000
"""For a recording: a busy machine may let a minute of scans wait."""


class Stamped(NamedTuple):
    """A value and its stamp in whole nanoseconds."""

    stamp_ns: int
    value: Any


class Paired(NamedTuple):
    """A leader that is ready to be answered, and each source's value that belongs to it, or None."""

    leader: Stamped
    values: dict[str, Stamped | None]

    def fresh(self, source: str, max_age_ns: int, default: Any) -> Any:
        """Return the source's value, or ``default`` if there is none within ``max_age_ns`` of the leader."""
        found = self.values[source]
        if found is None or abs(self.leader.stamp_ns - found.stamp_ns) > max_age_ns:
            return default
        return found.value


class StampPairing:
    """Finds for each leader, such as a scan or a command, the message of each source that belongs to it.

    That is the message of the leader's own stamp. Where there is none, it is the source's newest one.

    Messages of one instant come over different connections, so a leader may overtake what belongs to it. Some
    sources share their stamps with the leaders. A leader waits for the message of such a source. So the
    outcome does not depend on which message was faster. The leader waits until the next leader comes at the
    latest. If a source's message did not come until then, no leader waits for this source until it shares a
    stamp again. A source may be slower than the leaders and share the stamp of every fourth. Then only every
    fourth waits.

    Args:
        sources: names of the sources.
        nearest: sources of which the message with the nearest stamp counts, instead of the newest.
        own_rate: sources with a rate of their own. No leader waits for one until it has shared two stamps.
            They tell how often it shares one.
        trusting: whether leaders wait for a source from its first message on. Otherwise all wait once it
            has shared a stamp, until it fails.
        patient: for a recording, in which no message is missing and no leader is urgent. A leader waits until
            each source has given its message or a newer one. Then the newest message that is not newer than
            the leader counts. The outcome depends on the messages alone, not on when they came.
    """

    def __init__(
        self,
        sources: tuple[str, ...],
        nearest: tuple[str, ...] = (),
        own_rate: tuple[str, ...] = (),
        trusting: bool = True,
        patient: bool = False,
    ):
        self._sources, self._nearest, self._own_rate = sources, nearest, own_rate
        self._trusting, self._patient = trusting, patient
        self._silenced: set[str] = set()
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        kept = PATIENT_MESSAGES if self._patient else KEPT_MESSAGES
        self._messages: dict[str, deque] = {source: deque(maxlen=kept) for source in self._sources}
        self._shares_stamps = dict.fromkeys(self._sources, self._trusting)
        self._shared: dict[str, deque] = {source: deque(maxlen=KEPT_SHARED) for source in self._sources}
        self._offered = 0
        self._jumped_back: set[str] = set()  # sources whose stamps went back since the last leader
        self._leader_stamps: deque = deque(maxlen=KEPT_LEADERS)
        self._held: deque[Stamped] = deque()

    def wait_for(self, source: str, waits: bool) -> None:
        """Let leaders wait for a source, or not while nobody listens to it."""
        (self._silenced.discard if waits else self._silenced.add)(source)

    def restart(self) -> None:
        """Forget the messages from before the clock jumped back. Call it when a leader shows that jump.

        A source whose stamps went back earlier is on the new clock already. Its messages are kept.
        """
        of_new_clock = {source: self._messages[source] for source in self._jumped_back}
        self.clear()
        self._messages.update(of_new_clock)

    def lead(self, stamp_ns: int, value: Any) -> list[Paired]:
        """Take in a leader; return the leaders that are ready now, oldest first."""
        ready = [self._release()] if len(self._held) == (PATIENT_LEADERS if self._patient else 1) else []
        self._jumped_back.clear()
        if not self._leader_stamps or stamp_ns != self._leader_stamps[-1]:  # a leader may be sent again
            self._offered += 1
        self._leader_stamps.append(stamp_ns)
        self._held.append(Stamped(stamp_ns, value))
        return ready + self._ready()

    def offer(self, source: str, stamp_ns: int, value: Any) -> list[Paired]:
        """Take in a source's message; return the leaders that are ready now, oldest first."""
        messages = self._messages[source]
        if messages and stamp_ns < messages[-1].stamp_ns:
            messages.clear()  # its clock jumped back
            self._jumped_back.add(source)
        messages.append(Stamped(stamp_ns, value))
        if stamp_ns in self._leader_stamps:
            back = next(
                i for i, leader_ns in enumerate(reversed(self._leader_stamps)) if leader_ns == stamp_ns
            )
            self._share(source, self._offered - 1 - back)
        return self._ready() if self._held else []

    @property
    def held(self) -> int:
        """Number of leaders that wait for their messages."""
        return len(self._held)

    @property
    def due(self) -> tuple[str, ...]:
        """The sources whose message for the oldest held leader is still to come."""
        return tuple(source for source in self._sources if self._is_due(source)) if self._held else ()

    def _ready(self) -> list[Paired]:
        ready = []
        while self._held and not self.due:
            ready.append(self._release())
        return ready

    def _is_due(self, source: str) -> bool:
        messages, leader_ns = self._messages[source], self._held[0].stamp_ns
        if source in self._silenced:
            return False
        if self._patient:
            return not messages or messages[-1].stamp_ns < leader_ns
        to_come = bool(messages) and self._shares_stamps[source] and messages[-1].stamp_ns < leader_ns
        return to_come and self._has_turn(source, self._number_of_oldest())

    def _has_turn(self, source: str, number: int) -> bool:
        """Whether the source, if it goes on as before, has a message for the leader with this number."""
        if not self._trusting:
            return True
        shared = self._shared[source]
        if source in self._own_rate and len(shared) < 2:
            return False
        period = min((later - earlier for earlier, later in zip(shared, list(shared)[1:])), default=1)
        return not shared or number - shared[-1] >= period

    def _number_of_oldest(self) -> int:
        return self._offered - len(self._held)

    def _share(self, source: str, number: int) -> None:
        """Take in that a message of the source has the stamp of the leader with this number."""
        self._shares_stamps[source] = True
        shared = self._shared[source]
        if not shared or number > shared[-1]:
            shared.append(number)

    def _release(self) -> Paired:
        number = self._number_of_oldest()
        leader = self._held.popleft()
        values = {source: self._find(source, leader.stamp_ns, number) for source in self._sources}
        return Paired(leader, values)

    def _find(self, source: str, stamp_ns: int, number: int) -> Stamped | None:
        messages = self._messages[source]
        for message in reversed(messages):
            if message.stamp_ns == stamp_ns:
                self._share(source, number)
                return message
        if not messages:
            return None
        if self._has_turn(source, number):
            self._shares_stamps[source] = False
        if source in self._nearest:
            return min(messages, key=lambda message: abs(message.stamp_ns - stamp_ns))
        if self._patient:
            return next((message for message in reversed(messages) if message.stamp_ns < stamp_ns), None)
        return messages[-1]
