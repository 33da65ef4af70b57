"""MAVROS's plugin `rc_io`."""

from __future__ import annotations

from mavros_msgs.msg import OverrideRCIn, RCIn, RCOut
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools_ros.mavros.uas import Uas, stamp_from_ms, stamp_from_us

_MOST_CHANNELS, _OUTPUTS = 18, 16


class RcIoPlugin:
    """Publishes rc/in, silent while there is no remote control, and rc/out; takes rc/override."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._in = uas.advertise("rc/in", RCIn)
        self._out = uas.advertise("rc/out", RCOut)
        uas.subscribe("rc/override", OverrideRCIn, self._on_override)
        uas.client.on("RC_CHANNELS", self._on_channels)
        uas.client.on("SERVO_OUTPUT_RAW", self._on_outputs)

    def _on_channels(self, message: common.MAVLink_message) -> None:
        self._in.publish(lambda: rc_in_message(message))

    def _on_outputs(self, message: common.MAVLink_message) -> None:
        if message.port == 0:
            self._out.publish(lambda: rc_out_message(message))

    def _on_override(self, message: OverrideRCIn) -> None:
        target = self._uas.client.target
        self._uas.client.send(
            common.MAVLink_rc_channels_override_message(
                target.system_id, target.component_id, *message.channels
            )
        )


def rc_in_message(channels: common.MAVLink_message) -> RCIn:
    """RC_CHANNELS to RCIn."""
    count = min(channels.chancount, _MOST_CHANNELS)
    return RCIn(
        header=Header(stamp=stamp_from_ms(channels.time_boot_ms)),
        rssi=channels.rssi,
        channels=[getattr(channels, f"chan{i}_raw") for i in range(1, count + 1)],
    )


def rc_out_message(outputs: common.MAVLink_message) -> RCOut:
    """SERVO_OUTPUT_RAW to RCOut."""
    return RCOut(
        header=Header(stamp=stamp_from_us(outputs.time_usec)),
        channels=[getattr(outputs, f"servo{i}_raw") for i in range(1, _OUTPUTS + 1)],
    )
