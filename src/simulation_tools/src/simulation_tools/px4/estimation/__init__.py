"""The flight controller's state estimate."""
