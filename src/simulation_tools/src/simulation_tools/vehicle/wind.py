"""Wind with gusts, described as PX4's wind plugin for Gazebo describes it.

The plugin draws speed and direction from normal distributions, independently at each of its updates. Here
both wander. They are first-order Gauss-Markov processes with the plugin's means and variances. Their
correlation time is the time between two updates (1 / windPubRate). The wind jumps only where a gust begins or
ends.
"""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass
from typing import Sequence

import numpy as np

from flight_basics.checks import check_limits, limited
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import ORIGIN, Vector3
from simulation_tools.sdf.elements import World
from simulation_tools.sdf.plugins import PluginReader

WIND_PLUGIN = "libgazebo_wind_plugin.so"
LENGTH_M = 15.5
INTENSITY = 0.2
"""Dryden's turbulence 2 m above the ground (MIL-F-8785C, 3.7.3.4): the scale length along the wind, and the
standard deviation of the wind's speed over its mean 6 m above the ground."""


class WindError(SimulationToolsError):
    """A wind is described wrongly."""


@dataclass(frozen=True)
class AirStream:
    """Air that blows from start_s to end_s: a speed along a direction, both of which wander.

    deviation_m_s: standard deviation of the speed, which stays between 0 and max_m_s. direction: of the mean,
    in the world; any length but zero. direction_deviation: standard deviation of each component of the unit
    vector along it. correlation_s: how long a deviation lasts. ramp_s: time in which the speed grows from
    zero.
    """

    mean_m_s: float = limited(MISSING, 0.0)
    deviation_m_s: float = limited(0.0, 0.0)
    max_m_s: float = limited(100.0, 0.0)
    direction: Vector3 = (1.0, 0.0, 0.0)
    direction_deviation: float = limited(0.0, 0.0)
    start_s: float = limited(0.0, 0.0)
    end_s: float = math.inf
    correlation_s: float = limited(0.5, above=0.0)
    ramp_s: float = limited(0.0, 0.0)

    def __post_init__(self) -> None:
        check_limits(self, WindError, "The wind's {}")
        if not self.start_s <= self.end_s:
            raise WindError(f"A wind must not end, at {self.end_s} s, before it begins, at {self.start_s} s.")
        if not 0.0 < math.hypot(*self.direction) < math.inf:
            raise WindError(f"A wind needs a direction, not {self.direction}.")

    @classmethod
    def gusty(cls, mean_m_s: float, direction_rad: float) -> AirStream:
        """Return a level wind with Dryden's turbulence. direction_rad: where it blows to, in the world."""
        return cls(
            mean_m_s,
            INTENSITY * mean_m_s,
            direction=(math.cos(direction_rad), math.sin(direction_rad), 0.0),
            direction_deviation=INTENSITY,
            correlation_s=LENGTH_M / max(mean_m_s, 0.1),
        )


class Wind:
    """The sum of several air streams."""

    def __init__(self, streams: Sequence[AirStream], rng: np.random.Generator) -> None:
        """rng: source of what wanders."""
        self._streams = tuple(streams)
        self._rng = rng
        self.restart()

    def restart(self) -> None:
        """Begin anew; whoever rewinds the random stream gets the same wind again."""
        self._states: list[np.ndarray | None] = [None] * len(self._streams)

    def step(self, time_s: float, dt_s: float) -> Vector3:
        """Advance by dt_s; return the velocity of the air at a time, m/s in the world."""
        total = ORIGIN
        for index, stream in enumerate(self._streams):
            drawn, before = self._rng.standard_normal(4), self._states[index]
            kept = math.exp(-dt_s / stream.correlation_s)
            state = drawn if before is None else kept * before + math.sqrt(1.0 - kept * kept) * drawn
            self._states[index] = state
            if stream.start_s <= time_s < stream.end_s:
                x, y, z = _velocity(stream, state.tolist())
                part = min((time_s - stream.start_s) / stream.ramp_s, 1.0) if stream.ramp_s else 1.0
                total = (total[0] + part * x, total[1] + part * y, total[2] + part * z)
        return total


def _velocity(stream: AirStream, state: Sequence[float]) -> Vector3:
    """Return a stream's velocity from its four standard normal deviations."""
    speed = min(abs(stream.mean_m_s + stream.deviation_m_s * state[0]), stream.max_m_s)
    length = math.hypot(*stream.direction)
    x, y, z = (
        speed * (mean / length + stream.direction_deviation * deviation)
        for mean, deviation in zip(stream.direction, state[1:])
    )
    return x, y, z


def streams_of(world: World) -> tuple[AirStream, ...]:
    """Return the air streams of a world's wind plugins. Raises WindError with path and line."""
    found: list[AirStream] = []
    for plugin in world.plugins:
        if plugin.filename == WIND_PLUGIN:
            found += _read(PluginReader(world.source or world.name, plugin, WindError))
    return tuple(stream for stream in found if stream.mean_m_s or stream.deviation_m_s)


def _read(read: PluginReader) -> list[AirStream]:
    """Return the wind, the gust and the ramp of one plugin, with the plugin's defaults."""
    gust_start_s = read.number("windGustStart", 10.0)
    gust_end_s = gust_start_s + read.number("windGustDuration", 0.0)
    rate_name = "publishRate" if read.has("publishRate") else "windPubRate"  # its name before 2021
    rate_hz = read.number(rate_name, 2.0)
    if not rate_hz > 0.0:
        raise read.error(f"<{rate_name}> must be positive, got {rate_hz:g}")
    variances = [
        read.number(name, 0.0)
        for name in (
            "windVelocityVariance",
            "windDirectionVariance",
            "windGustVelocityVariance",
            "windGustDirectionVariance",
        )
    ]
    if min(variances) < 0.0:
        raise read.error("a variance must not be negative")
    wind, wind_direction, gust, gust_direction = map(math.sqrt, variances)
    described = (
        (
            read.number("windVelocityMean", 0.0),
            wind,
            read.number("windVelocityMax", 100.0),
            read.vector("windDirectionMean", (1.0, 0.0, 0.0)),
            wind_direction,
            0.0,
            math.inf,
        ),
        (
            read.number("windGustVelocityMean", 0.0),
            gust,
            read.number("windGustVelocityMax", 10.0),
            read.vector("windGustDirectionMean", (0.0, 1.0, 0.0)),
            gust_direction,
            gust_start_s,
            gust_end_s,
        ),
    )
    try:
        return [*(AirStream(*values, 1.0 / rate_hz) for values in described), *_ramp(read)]
    except WindError as error:
        raise read.error(str(error)[:-1]) from None


def _ramp(read: PluginReader) -> list[AirStream]:
    """Return the wind that a plugin adds bit by bit, as a steady stream; none if it takes no time."""
    ramp_s = read.number("windChangeRampDuration", 0.0)
    vector = read.vector("windRampWindVectorComponents", ORIGIN)
    speed_m_s = math.hypot(*vector)
    if ramp_s <= 0.0 or speed_m_s == 0.0:
        return []
    start_s = read.number("windRampStart", 0.0)
    return [AirStream(speed_m_s, max_m_s=speed_m_s, direction=vector, start_s=start_s, ramp_s=ramp_s)]
