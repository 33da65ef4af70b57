"""The battery, as the flight controller tells of it."""
