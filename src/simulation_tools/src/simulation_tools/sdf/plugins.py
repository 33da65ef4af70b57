"""Reader of ``<plugin>``; the code that knows a plugin's name reads its parameters."""

from __future__ import annotations

from simulation_tools.sdf.document import Node
from simulation_tools.sdf.elements import Plugin

# Plugins, by the name of their library, whose work another part of the simulator does. Any other plugin is
# kept too, but it has no effect, and the document's warning names it.
KNOWN_LIBRARIES = frozenset(
    {
        "libgazebo_motor_model.so",
        "libsimulation_tools_linear_rotor.so",
        "libsimulation_tools_body_drag.so",
        "libsimulation_tools_gimbal.so",
        "libgazebo_multirotor_base_plugin.so",
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


def read_plugins(node: Node) -> tuple[Plugin, ...]:
    """Return the plugins of an element. Unknown ones stay marked as not understood."""
    known: list[Plugin] = []
    unknown: list[Plugin] = []
    for plugin in node.children_unmarked("plugin"):
        filename = plugin.attribute("filename")
        is_known = filename in KNOWN_LIBRARIES
        parameters = plugin.flattened(understand=is_known)
        (known if is_known else unknown).append(
            Plugin(plugin.attribute("name"), filename, parameters, plugin.line)
        )
    return (*known, *unknown)
