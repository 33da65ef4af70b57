"""The worlds of the experiments: how they are written, chosen, and read as a floor plan."""
