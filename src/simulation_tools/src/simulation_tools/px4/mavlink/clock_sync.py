"""The clocks of MAVLink's clients: answers TIMESYNC, and puts their stamps into PX4's time."""

from __future__ import annotations

from pymavlink.dialects.v20 import common

from simulation_tools.timesync import ClockOffset

SAME_CLOCK_S = 0.1  # PX4's filter calls a greater deviation an outlier


class ClockSync:
    """The clock of the clients on one channel.

    Clients of a simulation stamp by simulated time, which is the flight controller's. Such stamps count as
    they are. Stamps of another clock are shifted by the measured offset. As in PX4, they count only after 500
    exchanges (50 s); until then the time of arrival counts.
    """

    def __init__(self) -> None:
        self._offset = ClockOffset()
        self._offset_us = 0

    def hear(self, m: common.MAVLink_message, now_us: int) -> common.MAVLink_message | None:
        """Take in TIMESYNC. Return the answer, if it asks for one."""
        if m.tc1 == 0:
            return common.MAVLink_timesync_message(max(1000 * now_us, 1), m.ts1)  # a zero means a question
        self._offset_us = self._offset.add(m.ts1, m.tc1, 1000 * now_us).estimated_offset_ns // 1000
        return None

    def own_time_us(self, client_us: int, now_us: int) -> int:
        """Return a client's stamp in the flight controller's time."""
        if abs(self._offset_us) <= 1e6 * SAME_CLOCK_S:
            return client_us
        return client_us + self._offset_us if self._offset.converged else now_us
