"""Inner loops of the exploration."""
