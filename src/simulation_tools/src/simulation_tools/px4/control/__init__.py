"""The cascade from position setpoint to rotor command, and the take-off ramp that limits it."""
