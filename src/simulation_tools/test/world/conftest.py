"""Worlds and bodies that the tests of this folder share."""

from __future__ import annotations

import pytest

from simulation_tools.sdf.elements import World
from simulation_tools.sdf.parser import parse_model
from simulation_tools.world.world import PhysicsWorld

GROUND = (
    '<static>true</static><link name="link"><collision name="collision"><geometry><plane/></geometry>'
    "</collision></link>"
)


def model(body: str, name: str = "thing"):
    return parse_model(f'<sdf version="1.6"><model name="{name}">{body}</model></sdf>', "text", [])


def shape(geometry: str, pose: str = "0 0 0 0 0 0", name: str = "c", more: str = "") -> str:
    return f'<collision name="{name}"><pose>{pose}</pose><geometry>{geometry}</geometry>{more}</collision>'


def box(x: float, y: float, z: float) -> str:
    return f"<box><size>{x} {y} {z}</size></box>"


def mass(kg: float, ixx: float, iyy: float, izz: float, pose: str = "0 0 0 0 0 0") -> str:
    return (
        f"<inertial><pose>{pose}</pose><mass>{kg}</mass><inertia><ixx>{ixx}</ixx><iyy>{iyy}</iyy>"
        f"<izz>{izz}</izz></inertia></inertial>"
    )


def solid_box(x: float, y: float, z: float, kg: float, name: str = "thing", more: str = ""):
    """Return a model of a homogeneous box, centred on its frame."""
    inertia = (kg * (y * y + z * z) / 12, kg * (x * x + z * z) / 12, kg * (x * x + y * y) / 12)
    return model(f'<link name="l">{mass(kg, *inertia)}{shape(box(x, y, z), more=more)}</link>', name)


def still_box(x: float, y: float, z: float, name: str = "wall"):
    """Return a static model of a box."""
    return model(f'<static>true</static><link name="l">{shape(box(x, y, z))}</link>', name)


@pytest.fixture
def build():
    """Return a function that builds worlds and closes them at the end of the test."""
    worlds = []

    def make(*models, gravity=(0.0, 0.0, -9.8), time_step_s=0.004, ground=False):
        everything = (model(GROUND, "ground_plane"), *models) if ground else models
        worlds.append(PhysicsWorld(World("w", everything, gravity), time_step_s))
        return worlds[-1]

    yield make
    for world in worlds:
        world.close()
