"""The cascade from position setpoint to rotor command, and the ramp that limits the take-off."""
