"""MAVROS's plugin `vfr_hud`."""

from __future__ import annotations

from genpy import Time
from mavros_msgs.msg import VFR_HUD
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools_ros.mavros.uas import Uas


class VfrHudPlugin:
    """Publishes vfr_hud."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._hud = uas.advertise("vfr_hud", VFR_HUD)
        uas.client.on("VFR_HUD", self._on_hud)

    def _on_hud(self, message: common.MAVLink_message) -> None:
        self._hud.publish(lambda: vfr_hud_message(message, self._uas.now))


def vfr_hud_message(hud: common.MAVLink_message, stamp: Time) -> VFR_HUD:
    """VFR_HUD to VFR_HUD."""
    return VFR_HUD(
        header=Header(stamp=stamp),
        airspeed=hud.airspeed,
        groundspeed=hud.groundspeed,
        heading=hud.heading,
        throttle=0.01 * hud.throttle,
        altitude=hud.alt,
        climb=hud.climb,
    )
