"""The content of an SDF file as frozen dataclasses: checked, with every ``<include>`` and pose resolved.

Lengths in metres, angles in radians, masses in kilograms. Each class's docstring names its poses' frame,
whatever ``frame`` attribute the file used. Defaults are those of the SDF 1.6 specification.
"""

from simulation_tools.sdf.elements.model import DEFAULT_INERTIAL, Inertial, Joint, Link, Model, World
from simulation_tools.sdf.elements.script import Script, Trajectory, Waypoint
from simulation_tools.sdf.elements.sensors import (
    NO_NOISE,
    AirPressureSensor,
    CameraSensor,
    ImuSensor,
    Noise,
    Plugin,
    RaySensor,
    ScanAxis,
    Sensor,
)
from simulation_tools.sdf.elements.shapes import (
    DEFAULT_SURFACE,
    Box,
    Collision,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Plane,
    Polyline,
    Rgba,
    Sphere,
    Surface,
    Visual,
)

__all__ = [
    "DEFAULT_INERTIAL",
    "DEFAULT_SURFACE",
    "NO_NOISE",
    "AirPressureSensor",
    "Box",
    "CameraSensor",
    "Collision",
    "Cylinder",
    "Geometry",
    "Heightmap",
    "ImuSensor",
    "Inertial",
    "Joint",
    "Link",
    "Mesh",
    "Model",
    "Noise",
    "Plane",
    "Plugin",
    "Polyline",
    "RaySensor",
    "Rgba",
    "ScanAxis",
    "Script",
    "Sensor",
    "Sphere",
    "Surface",
    "Trajectory",
    "Visual",
    "Waypoint",
    "World",
]
