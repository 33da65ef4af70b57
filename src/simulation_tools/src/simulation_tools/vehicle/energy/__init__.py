"""The energy of the UAV: what its rotors and devices draw, and the battery that gives it."""
