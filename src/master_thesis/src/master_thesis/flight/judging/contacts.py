"""Judges contacts: whether the UAV touched an obstacle, or stands on the ground."""

from __future__ import annotations

GROUND = "ground_plane"  # its name in Gazebo's own worlds; other grounds are found by what carries the UAV
CARRIES = 0.7
"""The UAV stands on a touched shape if the normal's z is at least this: 45 degrees of slope."""


def touched_by(uav: str, collision_1: str, collision_2: str) -> str:
    """Return the one of two collision shapes (model::link::collision) that is not the UAV's."""
    return collision_2 if _is_of(uav, collision_1) else collision_1


class Contacts:
    """The shapes that the UAV has touched so far, and the ones that carried it.

    A contact with the ground is normal at take-off and landing, and a collision in flight. Any model that
    carries the UAV from below before or after the flight is ground.
    """

    def __init__(self, uav: str) -> None:
        """Judge the contacts of the model named `uav`."""
        self._uav = uav
        self._touched: dict[str, None] = {}
        self._ground: dict[str, None] = {GROUND: None}

    @property
    def touched(self) -> tuple[str, ...]:
        """The touched collision shapes of obstacles."""
        return tuple(self._touched)

    @property
    def ground(self) -> tuple[str, ...]:
        """The models that carried the UAV."""
        return tuple(self._ground)

    def judge(
        self, collision_1: str, collision_2: str, upwards: float, in_flight: bool, finds_ground: bool = True
    ) -> None:
        """Take a contact between two collision shapes (model::link::collision).

        upwards: z component of the contact's normal, the unit vector from the second shape to the first.
        finds_ground: whether what carries the UAV outside of the flight is ground. Not where it lands between
        two flights: there it comes back to what it began on.
        """
        shape = touched_by(self._uav, collision_1, collision_2)
        model = shape.split("::")[0]
        carries = upwards if _is_of(self._uav, collision_1) else -upwards
        if not in_flight and finds_ground and carries >= CARRIES:
            self._ground.setdefault(model)
        if in_flight or model not in self._ground:
            self._touched.setdefault(shape)


def _is_of(uav: str, collision: str) -> bool:
    return collision.split("::")[0] == uav
