"""Between messages and the volume."""
