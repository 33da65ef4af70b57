"""The worlds of the experiments: written as SDF, chosen by name, and read as a floor plan."""
