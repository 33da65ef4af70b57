"""The UDP ports on which PX4 SITL and its clients listen."""

from __future__ import annotations

MAVROS_PORT = 14540  # where MAVROS, and any offboard client, listens for PX4
GCS_PORT = 14550  # where a ground station listens for PX4
OFFBOARD_PORT_STEP = 14580 - MAVROS_PORT
GCS_PORT_STEP = 18570 - GCS_PORT


def own_ports(offboard_port: int, gcs_port: int) -> tuple[int, int]:
    """Return the ports that PX4 itself binds, from those of its clients; 0: any that is free."""
    return (
        offboard_port + OFFBOARD_PORT_STEP if offboard_port else 0,
        gcs_port + GCS_PORT_STEP if gcs_port else 0,
    )
