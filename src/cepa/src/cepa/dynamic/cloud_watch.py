"""Watches whether clouds come with the scans."""

from __future__ import annotations

import math

from cepa.dynamic.constants.cost_to_go import (
    CLOUD_PERIOD_SHARE,
    SILENCE_LEAST_S,
    SILENCE_MOST_S,
    SILENCE_PERIODS,
)
from cepa.dynamic.constants.obstacle_tracks import SHOWS_LOADS_RAD
from cepa.motion import Cloud


class CloudWatch:
    """Knows whether clouds come with the scans: a cloud's topic may die in flight while the scan goes on."""

    def __init__(self) -> None:
        self._newest_s = self._now_s = -math.inf
        self._period_s: float | None = None
        self._was_silent = False
        self.looks_all_around = self.looks_up = False

    def take_in(self, cloud: Cloud | None, stamp_s: float) -> None:
        """Take in the cloud of a scan with this stamp; None: none came."""
        self._now_s = stamp_s
        if cloud is None:
            return
        if math.isfinite(self._newest_s):
            period_s = self._period_s or self.silence_s
            self._period_s = period_s + CLOUD_PERIOD_SHARE * (self.silence_s - period_s)
        self._newest_s, self.looks_all_around = stamp_s, cloud.looks_all_around
        self.looks_up = cloud.elevation_rad[1] >= SHOWS_LOADS_RAD

    @property
    def silence_s(self) -> float:
        """How old the newest cloud is, s; inf: none has come."""
        return self._now_s - self._newest_s if math.isfinite(self._newest_s) else math.inf

    @property
    def is_silent(self) -> bool:
        """Whether more clouds are missing than may get lost now and then."""
        waited_s = SILENCE_PERIODS * (self._period_s or 0.0)
        return self.silence_s > min(max(waited_s, SILENCE_LEAST_S), SILENCE_MOST_S)

    def news(self) -> tuple[str, ...]:
        """Return a sentence if clouds stay away, or come again, since the last call."""
        is_silent = self.is_silent and math.isfinite(self.silence_s)
        changed, self._was_silent = is_silent != self._was_silent, is_silent
        if not changed:
            return ()
        if not is_silent:
            return ("Clouds come with the scans again.",)
        return (
            f"No cloud has come with the scans for {self.silence_s:.2f} s: the UAV flies by the "
            "planar scan and by what clouds showed before. Check the cloud's topic and its stamps.",
        )
