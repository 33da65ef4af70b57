"""Judges contacts: whether the UAV touched an obstacle, or stands on the ground."""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.sdf.elements import Model
from simulation_tools.vehicle.rotor_plugins import rotor_links
from simulation_tools.vehicle.uav import load_uav

GROUND = "ground_plane"  # its name in Gazebo's own worlds; other grounds are found by what carries the UAV
CARRIES = 0.7
"""The UAV stands on a touched shape if the normal's z is at least this: 45 degrees of slope."""


@dataclass(frozen=True)
class UavParts:
    """What the names of a UAV's collision shapes (model::link::collision) begin with.

    model: its name in the world. rotors: names of the links that are rotors.
    """

    model: str
    rotors: frozenset[str]

    @classmethod
    def of(cls, model: Model) -> UavParts:
        """Return the parts of a model."""
        return cls(model.name, rotor_links(model))

    @classmethod
    def load(cls, model: str) -> UavParts:
        """Return the parts of a model of the model path, or of an SDF file; raises SimulationToolsError."""
        return cls.of(load_uav(model).model)

    def rotor_of(self, collision: str) -> str:
        """Return the rotor to which one of the UAV's shapes belongs; empty: to none."""
        link = collision.split("::")[1] if collision.count("::") else ""
        return link if link in self.rotors else ""


def touched_by(uav: str, collision_1: str, collision_2: str) -> str:
    """Return the one of two collision shapes (model::link::collision) that is not the UAV's."""
    return collision_2 if _is_of(uav, collision_1) else collision_1


class Contacts:
    """The shapes that the UAV has touched so far, and the ones that carried it.

    A contact with the ground is normal at take-off and landing, and a collision in flight. Any model that
    carries the UAV from below before or after the flight is ground. What a rotor touches is touched, at any
    time, ground or not: a UAV stands on its legs.
    """

    def __init__(self, uav: UavParts) -> None:
        """Judge the contacts of a UAV."""
        self._uav = uav
        self._touched: dict[str, str] = {}
        self._ground: dict[str, None] = {GROUND: None}

    @property
    def touched(self) -> tuple[str, ...]:
        """The touched collision shapes of obstacles."""
        return tuple(self._touched)

    @property
    def failure(self) -> str | None:
        """The sentence about what the UAV has touched; None: nothing."""
        if not self._touched:
            return None
        return f"The UAV touched {', '.join(f'{shape}{part}' for shape, part in self._touched.items())}."

    @property
    def ground(self) -> tuple[str, ...]:
        """The models that carried the UAV."""
        return tuple(self._ground)

    def classify(
        self, collision_1: str, collision_2: str, upwards: float, in_flight: bool, finds_ground: bool = True
    ) -> bool:
        """Take a contact between two collision shapes (model::link::collision). Return whether it is ground.

        upwards: z component of the contact's normal, the unit vector from the second shape to the first.
        finds_ground: whether what carries the UAV outside of the flight is ground. Not where it lands between
        two flights: there it comes back to what it began on.
        """
        is_first = _is_of(self._uav.model, collision_1)
        own, shape = (collision_1, collision_2) if is_first else (collision_2, collision_1)
        model, rotor = shape.split("::")[0], self._uav.rotor_of(own)
        carries = upwards if is_first else -upwards
        if not in_flight and finds_ground and carries >= CARRIES:
            self._ground.setdefault(model)
        is_ground = model in self._ground
        if in_flight or not is_ground or rotor:
            self._touched.setdefault(shape, f" with {rotor}" if rotor else "")
        return is_ground


def _is_of(uav: str, collision: str) -> bool:
    return collision.split("::")[0] == uav
