"""Writes SDF 1.6 worlds of boxes, cylinders and spheres.

They load in this workspace's simulator and in Gazebo classic. Units are metres and radians; x forward, y
left, z up. A prop's origin is on the floor.
"""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.sdf.elements import Cylinder, Sphere


@dataclass(frozen=True)
class Box:
    """A box of the given edge lengths along its own x, y and z."""

    x_m: float
    y_m: float
    z_m: float


Shape = Box | Cylinder | Sphere


@dataclass(frozen=True)
class Colour:
    """Red, green and blue from 0 to 1; transparency: 0 is opaque."""

    red: float
    green: float
    blue: float
    transparency: float = 0.0


@dataclass(frozen=True)
class Part:
    """One shape of a prop. `centre` is in the prop's frame; without a height it stands on the floor."""

    name: str
    shape: Shape
    colour: Colour
    centre: tuple[float, float, float] | None = None
    solid: bool = True


@dataclass(frozen=True)
class Prop:
    """A static model: where it stands, how it is turned, and its parts."""

    name: str
    x_m: float
    y_m: float
    parts: tuple[Part, ...]
    yaw_rad: float = 0.0


@dataclass(frozen=True)
class Walk:
    """A thing that goes its way once. waypoints: (time in s from the start, x, y, z in m, yaw in rad)."""

    name: str
    parts: tuple[Part, ...]
    waypoints: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Surroundings:
    """The floor's colour, the sky's, and where Gazebo's camera starts (x y z roll pitch yaw)."""

    floor: Colour
    sky: Colour = Colour(0.75, 0.83, 0.92)
    camera: tuple[float, ...] = (-12.0, -14.0, 14.0, 0.0, 0.5, 0.7)


def write_world(
    name: str,
    comment: str,
    surroundings: Surroundings,
    props: tuple[Prop, ...],
    walks: tuple[Walk, ...] = (),
) -> str:
    """Return the text of a world file: sun, floor plane, the props in their order, and what moves."""
    models = "".join([*map(_model, props), *map(_actor, walks)])
    return _WORLD.format(
        name=name,
        comment=comment,
        sky=_rgba(surroundings.sky),
        floor=_rgba(surroundings.floor),
        camera=_numbers(*surroundings.camera),
        models=models,
    )


def write_model(prop: Prop) -> str:
    """Return the text of a model file, as `spawn_sdf_model` takes it."""
    return f'<?xml version="1.0"?>\n<sdf version="1.6">\n{_model(prop)}</sdf>\n'


def _model(prop: Prop) -> str:
    parts = "".join(_part(part) for part in prop.parts)
    return (
        f'    <model name="{prop.name}">\n'
        "      <static>true</static>\n"
        f"      <pose>{_numbers(prop.x_m, prop.y_m, 0, 0, 0, prop.yaw_rad)}</pose>\n"
        f'      <link name="link">\n{parts}      </link>\n'
        "    </model>\n"
    )


def _actor(walk: Walk) -> str:
    parts = "".join(_part(part) for part in walk.parts)
    places = ((_numbers(t), _numbers(x, y, z, 0, 0, yaw)) for t, x, y, z, yaw in walk.waypoints)
    waypoints = "".join(
        f"          <waypoint><time>{time}</time><pose>{pose}</pose></waypoint>\n" for time, pose in places
    )
    return (
        f'    <actor name="{walk.name}">\n'
        f'      <link name="link">\n{parts}      </link>\n'
        '      <script>\n        <loop>false</loop>\n        <trajectory id="0" type="walk">\n'
        f"{waypoints}        </trajectory>\n      </script>\n"
        "    </actor>\n"
    )


def _part(part: Part) -> str:
    centre = part.centre or (0.0, 0.0, _height(part.shape) / 2)
    body = f"<pose>{_numbers(*centre, 0, 0, 0)}</pose>{_geometry(part.shape)}"
    colour = _rgba(part.colour)
    see_through = part.colour.transparency
    veil = f"<transparency>{see_through:g}</transparency>" if see_through else ""
    material = f"<material><ambient>{colour}</ambient><diffuse>{colour}</diffuse></material>{veil}"
    collision = f'        <collision name="{part.name}">{body}</collision>\n' if part.solid else ""
    return f'{collision}        <visual name="{part.name}_visual">{body}{material}</visual>\n'


def _geometry(shape: Shape) -> str:
    if isinstance(shape, Box):
        inner = f"<box><size>{_numbers(shape.x_m, shape.y_m, shape.z_m)}</size></box>"
    elif isinstance(shape, Cylinder):
        radius, length = _numbers(shape.radius_m), _numbers(shape.length_m)
        inner = f"<cylinder><radius>{radius}</radius><length>{length}</length></cylinder>"
    else:
        inner = f"<sphere><radius>{_numbers(shape.radius_m)}</radius></sphere>"
    return f"<geometry>{inner}</geometry>"


def _height(shape: Shape) -> float:
    if isinstance(shape, Box):
        return shape.z_m
    return shape.length_m if isinstance(shape, Cylinder) else 2 * shape.radius_m


def _rgba(colour: Colour) -> str:
    return _numbers(colour.red, colour.green, colour.blue, 1)


def _numbers(*values: float) -> str:
    """Write a number with four decimals, without trailing zeros and without a negative zero."""
    return " ".join(f"{round(float(value), 4) + 0.0:g}" for value in values)


_WORLD = """<?xml version="1.0"?>
<!-- {comment}
     Written by flights/worlds/ (rosrun flights make_worlds FOLDER): change it there. -->
<sdf version="1.6">
  <world name="{name}">
    <gravity>0 0 -9.80665</gravity>
    <physics type="ode">
      <max_step_size>0.004</max_step_size>
      <real_time_factor>1</real_time_factor>
      <real_time_update_rate>250</real_time_update_rate>
    </physics>
    <scene>
      <ambient>0.5 0.5 0.5 1</ambient>
      <background>{sky}</background>
      <shadows>true</shadows>
    </scene>
    <gui>
      <camera name="user_camera"><pose>{camera}</pose></camera>
    </gui>
    <light name="sun" type="directional">
      <cast_shadows>true</cast_shadows>
      <pose>0 0 10 0 0 0</pose>
      <diffuse>0.8 0.8 0.8 1</diffuse>
      <specular>0.2 0.2 0.2 1</specular>
      <direction>-0.5 0.3 -0.9</direction>
    </light>
    <model name="ground_plane">
      <static>true</static>
      <link name="link">
        <collision name="floor">
          <geometry><plane><normal>0 0 1</normal><size>120 80</size></plane></geometry>
        </collision>
        <visual name="floor_visual">
          <geometry><plane><normal>0 0 1</normal><size>120 80</size></plane></geometry>
          <material><ambient>{floor}</ambient><diffuse>{floor}</diffuse></material>
        </visual>
      </link>
    </model>
{models}  </world>
</sdf>
"""
