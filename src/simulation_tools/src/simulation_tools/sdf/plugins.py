"""Reader of ``<plugin>``. The code that knows a plugin's name reads its parameters by `PluginReader`."""

from __future__ import annotations

import math

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Vector3
from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Plugin
from simulation_tools.sdf.reading import Omissions

# Plugins, by the name of their library, whose work another part of the simulator does. Any other plugin is
# kept too, but it has no effect, and the document's warning names it.
KNOWN_LIBRARIES = frozenset(
    {
        "libgazebo_motor_model.so",
        "libsimulation_tools_linear_rotor.so",
        "libsimulation_tools_body_drag.so",
        "libsimulation_tools_gimbal.so",
        "libsimulation_tools_power_load.so",
        "libLinearBatteryPlugin.so",
        "ignition-gazebo-linearbatteryplugin-system",
        "gz-sim-linearbatteryplugin-system",
        "libgazebo_multirotor_base_plugin.so",
        "libgazebo_wind_plugin.so",
        "libgazebo_imu_plugin.so",
        "libgazebo_mavlink_interface.so",
        "libgazebo_ros_laser.so",
        "libgazebo_ros_gpu_laser.so",
        "libgazebo_ros_block_laser.so",
        "libgazebo_ros_imu_sensor.so",
        "libgazebo_ros_range.so",
        "libgazebo_ros_camera.so",
        "libgazebo_ros_depth_camera.so",
        "libgazebo_ros_p3d.so",
    }
)


WITHOUT_EFFECT = frozenset(
    {
        "robotNamespace",
        "frameId",
        "xyzOffset",
        "windPubTopic",
        "windSubTopic",
        "commandSubTopic",
        "motorSpeedPubTopic",
        "MotorFailureSubTopic",
        "motorFailureSubTopic",
        "motorType",
        "rotorVelocitySlowdownSim",
    }
)
"""Names of topics and settings for drawing, which have no meaning here."""
PARAMETERS: dict[str, frozenset[str]] = {
    "libgazebo_wind_plugin.so": frozenset(
        {
            "publishRate",
            "windPubRate",
            "windVelocityMean",
            "windVelocityMax",
            "windVelocityVariance",
            "windDirectionMean",
            "windDirectionVariance",
            "windGustStart",
            "windGustDuration",
            "windGustVelocityMean",
            "windGustVelocityMax",
            "windGustVelocityVariance",
            "windGustDirectionMean",
            "windGustDirectionVariance",
            "windRampStart",
            "windChangeRampDuration",
            "windRampWindVectorComponents",
        }
    ),
    "libgazebo_motor_model.so": frozenset(
        {
            "jointName",
            "linkName",
            "turningDirection",
            "timeConstantUp",
            "timeConstantDown",
            "maxRotVelocity",
            "idleRotVelocity",
            "motorConstant",
            "momentConstant",
            "motorNumber",
            "rotorDragCoefficient",
            "rollingMomentCoefficient",
        }
    ),
}
"""Parameters that are read, of plugins that change a flight. The warning names any other one."""


def read_plugins(node: Node, omissions: Omissions | None = None) -> tuple[Plugin, ...]:
    """Return the plugins of an element, the known ones first. Unknown ones stay marked as not understood.

    omissions: of the request, for a plugin that is bad; None: it is refused.
    """
    omissions = omissions or Omissions(is_lenient=False)
    read = [omissions.read(plugin, _read_plugin, None) for plugin in node.children_unmarked("plugin")]
    found = [plugin for plugin in read if plugin is not None]
    return tuple(sorted(found, key=lambda plugin: plugin.filename not in KNOWN_LIBRARIES))


def _read_plugin(node: Node) -> Plugin | None:
    filename, name = node.attribute("filename"), node.attribute("name")
    is_known = filename in KNOWN_LIBRARIES
    parameters = node.flattened(understand=is_known and filename not in PARAMETERS)
    if filename in PARAMETERS:
        node.understood().accept(*PARAMETERS[filename], *WITHOUT_EFFECT)
    return Plugin(name, filename, parameters, node.line)


class PluginReader:
    """Typed access to a plugin's parameters. Errors of one class say where, and what is wrong."""

    def __init__(self, source: str, plugin: Plugin, error_class: type[SimulationToolsError]) -> None:
        """source: the file (or name) that holds the plugin."""
        self._where = f"{source}:{plugin.line}"
        self._plugin = plugin
        self._error_class = error_class
        self.filename = plugin.filename

    def error(self, text: str) -> SimulationToolsError:
        """Return an error at the plugin's place."""
        return self._error_class(f"{self._where}: plugin {self._plugin.name!r}: {text}")

    def has(self, key: str) -> bool:
        """Whether a parameter is there."""
        return key in self._plugin.parameters

    def text(self, key: str) -> str:
        """Return a parameter's text, which must be there."""
        value = self._plugin.parameters.get(key)
        if value is None:
            raise self.error(f"<{key}> is missing")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """Return a parameter's finite number; without a default it must be there."""
        if default is not None and key not in self._plugin.parameters:
            return default
        try:
            value = float(self.text(key))
        except ValueError:
            raise self.error(f"<{key}> must be a number, got {self.text(key)!r}") from None
        if not math.isfinite(value):
            raise self.error(f"<{key}> must be finite, got {value}")
        return value

    def vector(self, key: str, default: Vector3) -> Vector3:
        """Return a parameter's three finite numbers, or the default."""
        if key not in self._plugin.parameters:
            return default
        try:
            x, y, z = map(float, self.text(key).split())
        except ValueError:
            raise self.error(f"<{key}> must be three numbers, got {self.text(key)!r}") from None
        if not math.isfinite(x + y + z):
            raise self.error(f"<{key}> must be finite, got {self.text(key)!r}")
        return x, y, z
