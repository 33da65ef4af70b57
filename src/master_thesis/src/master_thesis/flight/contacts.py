"""Where a contact is judged: whether the UAV touched an obstacle, or stands on the ground."""

from __future__ import annotations

GROUND = "ground_plane"  # what Gazebo's own worlds call it; any other is known by what the UAV stands on
CARRIES = 0.7
"""The UAV stands on what it touches if the contact's normal points up this much: 45 degrees of slope."""


def touched_by(uav: str, collision_1: str, collision_2: str) -> str:
    """Return that of two collision shapes, named model::link::collision, which is not the UAV's."""
    return collision_2 if _is_of(uav, collision_1) else collision_1


class Contacts:
    """What the UAV has touched so far, and what carried it.

    Touching the ground is part of take-off and landing, and a collision in flight. The ground is what carries
    the UAV from below while it is not in flight, whatever its name.
    """

    def __init__(self, uav: str) -> None:
        """Judge the contacts of the model named `uav`."""
        self._uav = uav
        self._touched: dict[str, None] = {}
        self._ground: dict[str, None] = {GROUND: None}

    @property
    def touched(self) -> tuple[str, ...]:
        """The collision shapes of obstacles that were touched."""
        return tuple(self._touched)

    @property
    def ground(self) -> tuple[str, ...]:
        """The models that carried the UAV."""
        return tuple(self._ground)

    def judge(self, collision_1: str, collision_2: str, upwards: float, in_flight: bool) -> None:
        """Take a contact between two collision shapes, named model::link::collision.

        upwards: z component of the contact's normal, the unit vector from the second shape to the first.
        """
        shape = touched_by(self._uav, collision_1, collision_2)
        model = shape.split("::")[0]
        carries = upwards if _is_of(self._uav, collision_1) else -upwards
        if not in_flight and carries >= CARRIES:
            self._ground.setdefault(model)
        if in_flight or model not in self._ground:
            self._touched.setdefault(shape)


def _is_of(uav: str, collision: str) -> bool:
    return collision.split("::")[0] == uav
