"""MAVROS's configuration of distance sensors: each name is a topic, in one of the two directions."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, Mapping

from pymavlink.dialects.v20 import common

_ROTATION = "MAV_SENSOR_ROTATION_"
ORIENTATIONS = {
    entry.name[len(_ROTATION) :]: number
    for number, entry in common.enums["MAV_SENSOR_ORIENTATION"].items()
    if entry.name.startswith(_ROTATION)
}
_VARIANCE_OF = 50  # ranges

# What MAVROS's px4_config.yaml holds
DEFAULT_SENSORS: Mapping[str, Mapping[str, Any]] = {
    "hrlv_ez4_pub": {
        "id": 0,
        "frame_id": "hrlv_ez4_sonar",
        "orientation": "PITCH_270",
        "field_of_view": 0.0,
    },
    "lidarlite_pub": {
        "id": 1,
        "frame_id": "lidarlite_laser",
        "orientation": "PITCH_270",
        "field_of_view": 0.0,
    },
    "sonar_1_sub": {"subscriber": True, "id": 2, "orientation": "PITCH_270"},
    "laser_1_sub": {"subscriber": True, "id": 3, "orientation": "PITCH_270"},
}


@dataclass(frozen=True)
class DistanceSensor:
    """One sensor of the configuration.

    Attributes:
        name: its topic, below distance_sensor/. sensor_id: MAVLink's. to_fcu: whether its ranges go to the
            flight controller. orientation: MAV_SENSOR_ORIENTATION; None: any.
        frame_id, field_of_view_rad: of the published ranges. variance_cm: that the flight controller is told;
            0: that of the last 50 ranges.
    """

    name: str
    sensor_id: int
    to_fcu: bool
    orientation: int | None
    frame_id: str
    field_of_view_rad: float
    variance_cm: int

    @classmethod
    def of(cls, name: str, values: Mapping[str, Any]) -> DistanceSensor:
        """Read a sensor's parameters. Raises ValueError: one that is needed is missing or no such thing."""
        to_fcu = bool(values.get("subscriber", False))
        needed = ("id", "orientation") if to_fcu else ("id", "frame_id", "field_of_view")
        missing = [key for key in needed if key not in values]
        if missing:
            raise ValueError(f"distance_sensor/{name} has no {missing[0]}")
        orientation = values.get("orientation")
        if orientation is not None and orientation not in ORIENTATIONS:
            raise ValueError(
                f"distance_sensor/{name}: {orientation!r} is not an orientation, as PITCH_270 is"
            )
        return cls(
            name,
            int(values["id"]),
            to_fcu,
            None if orientation is None else ORIENTATIONS[orientation],
            str(values.get("frame_id", "")),
            float(values.get("field_of_view", 0.0)),
            int(values.get("covariance", 0)),
        )


class RangesToFcu:
    """Builds DISTANCE_SENSOR of the ranges of one sensor."""

    def __init__(self, sensor: DistanceSensor) -> None:
        self._sensor = sensor
        self._last_m: deque[float] = deque(maxlen=_VARIANCE_OF)

    def message(
        self,
        time_boot_ms: int,
        range_m: float,
        limits_m: tuple[float, float],
        is_ultrasound: bool,
        field_of_view_rad: float,
    ) -> common.MAVLink_message:
        """Return the message of one range; one beyond all limits is the greatest number of cm.

        Raises ValueError: NaN.
        """
        if any(map(math.isnan, (range_m, *limits_m))):
            raise ValueError("its range is NaN")
        s = self._sensor
        return common.MAVLink_distance_sensor_message(
            time_boot_ms % 2**32,
            *(_cm(length_m) for length_m in (*limits_m, range_m)),
            common.MAV_DISTANCE_SENSOR_ULTRASOUND if is_ultrasound else common.MAV_DISTANCE_SENSOR_LASER,
            s.sensor_id,
            s.orientation or 0,
            s.variance_cm or self._variance_cm(range_m),
            field_of_view_rad,
            field_of_view_rad,
        )

    def _variance_cm(self, range_m: float) -> int:
        """MAVROS's figure: the variance in m2, times 100."""
        if math.isfinite(range_m):
            self._last_m.append(range_m)
        if not self._last_m:
            return 0
        mean = sum(self._last_m) / len(self._last_m)
        return min(int(100.0 * sum((r - mean) ** 2 for r in self._last_m) / len(self._last_m)), 255)


def _cm(length_m: float) -> int:
    return int(min(max(100.0 * length_m, 0.0), 65535.0))
