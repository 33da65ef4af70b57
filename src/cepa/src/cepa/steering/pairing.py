"""Pairs each scan with the reference and the odometry of the same stamp."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

KEPT_MESSAGES = 64
KEPT_SCANS = 8
KEPT_SHARED = 3
"""Of so many scans in a row that had a source's message, the least distance tells how often one has."""

PATIENT_MESSAGES = 20_000
PATIENT_SCANS = 2_000
"""For a recording: a busy machine may let a minute of scans wait."""


@dataclass(frozen=True)
class Stamped:
    """A value and its stamp in whole nanoseconds."""

    stamp_ns: int
    value: Any


@dataclass(frozen=True)
class PairedScan:
    """A scan that is ready to be answered, and each source's value that belongs to it, or None."""

    scan: Stamped
    values: dict[str, Stamped | None]

    def fresh(self, source: str, max_age_ns: int, default: Any) -> Any:
        """Return the source's value, or ``default`` where there is none within ``max_age_ns`` of the scan."""
        found = self.values[source]
        if found is None or abs(self.scan.stamp_ns - found.stamp_ns) > max_age_ns:
            return default
        return found.value


class ScanPairing:
    """Finds for each scan the message of each source that belongs to it.

    That is the message of the scan's own stamp. Where there is none, it is the source's newest one.

    Messages of one instant come over different connections, so a scan may overtake what belongs to it. Some
    sources share their stamps with the scans. A scan waits for the message of such a source. So the outcome
    does not depend on which message was faster. The scan waits until the next scan comes at the latest. If a
    source's message did not come until then, no scan waits for this source until it shares a stamp again.
    A source may be slower than the scans and share the stamp of every fourth. Then only every fourth waits.

    Args:
        sources: names of the sources.
        nearest: sources of which the message with the nearest stamp counts, instead of the newest.
        own_rate: sources with a rate of their own. No scan waits for one until it has shared two stamps. They
            tell how often it shares one.
        patient: for a recording, in which no message is missing and no scan is urgent. A scan waits until
            each source has given its message or a newer one. Then the newest message that is not newer than
            the scan counts. The outcome depends on the messages alone, not on when they came.
    """

    def __init__(
        self,
        sources: tuple[str, ...],
        nearest: tuple[str, ...] = (),
        own_rate: tuple[str, ...] = (),
        patient: bool = False,
    ):
        self._sources, self._nearest, self._own_rate, self._patient = sources, nearest, own_rate, patient
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        kept = PATIENT_MESSAGES if self._patient else KEPT_MESSAGES
        self._messages: dict[str, deque] = {source: deque(maxlen=kept) for source in self._sources}
        self._shares_stamps = dict.fromkeys(self._sources, True)  # trusted from a source's first message on
        self._shared: dict[str, deque] = {source: deque(maxlen=KEPT_SHARED) for source in self._sources}
        self._offered = 0
        self._jumped_back: set[str] = set()  # sources whose stamps went back since the last scan
        self._scan_stamps: deque = deque(maxlen=KEPT_SCANS)
        self._held: deque[Stamped] = deque()

    def restart(self) -> None:
        """Forget the messages from before the clock jumped back. Call it when a scan shows that jump.

        A source whose stamps went back earlier is on the new clock already. Its messages are kept.
        """
        of_new_clock = {source: self._messages[source] for source in self._jumped_back}
        self.clear()
        self._messages.update(of_new_clock)

    def offer_scan(self, stamp_ns: int, scan: Any) -> list[PairedScan]:
        """Take in a scan; return the scans that are ready now, oldest first."""
        ready = [self._release()] if len(self._held) == (PATIENT_SCANS if self._patient else 1) else []
        self._jumped_back.clear()
        if not self._scan_stamps or stamp_ns != self._scan_stamps[-1]:  # a scan may be sent again
            self._offered += 1
        self._scan_stamps.append(stamp_ns)
        self._held.append(Stamped(stamp_ns, scan))
        return ready + self._ready()

    def offer(self, source: str, stamp_ns: int, value: Any) -> list[PairedScan]:
        """Take in another message; return the scans that are ready now, oldest first."""
        messages = self._messages[source]
        if messages and stamp_ns < messages[-1].stamp_ns:
            messages.clear()  # its clock jumped back
            self._jumped_back.add(source)
        messages.append(Stamped(stamp_ns, value))
        for back, scan_ns in enumerate(reversed(self._scan_stamps)):
            if scan_ns == stamp_ns:
                self._share(source, self._offered - 1 - back)
                break
        return self._ready()

    @property
    def held(self) -> int:
        """Number of scans that wait for their messages."""
        return len(self._held)

    @property
    def due(self) -> tuple[str, ...]:
        """The sources whose message for the oldest held scan is still to come."""
        return tuple(source for source in self._sources if self._is_due(source)) if self._held else ()

    def _ready(self) -> list[PairedScan]:
        ready = []
        while self._held and not self.due:
            ready.append(self._release())
        return ready

    def _is_due(self, source: str) -> bool:
        messages, scan_ns = self._messages[source], self._held[0].stamp_ns
        if self._patient:
            return not messages or messages[-1].stamp_ns < scan_ns
        to_come = bool(messages) and self._shares_stamps[source] and messages[-1].stamp_ns < scan_ns
        return to_come and self._has_turn(source, self._number_of_oldest())

    def _has_turn(self, source: str, number: int) -> bool:
        """Whether the source, if it goes on as before, has a message for the scan with this number."""
        shared = self._shared[source]
        if source in self._own_rate and len(shared) < 2:
            return False
        period = min((later - earlier for earlier, later in zip(shared, list(shared)[1:])), default=1)
        return not shared or number - shared[-1] >= period

    def _number_of_oldest(self) -> int:
        return self._offered - len(self._held)

    def _share(self, source: str, number: int) -> None:
        """Take in that a message of the source has the stamp of the scan with this number."""
        self._shares_stamps[source] = True
        shared = self._shared[source]
        if not shared or number > shared[-1]:
            shared.append(number)

    def _release(self) -> PairedScan:
        number = self._number_of_oldest()
        scan = self._held.popleft()
        values = {source: self._find(source, scan.stamp_ns, number) for source in self._sources}
        return PairedScan(scan, values)

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
