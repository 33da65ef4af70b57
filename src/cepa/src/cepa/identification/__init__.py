"""How a UAV follows velocity commands: a model, and how to find it from a recording or a flight of steps."""
