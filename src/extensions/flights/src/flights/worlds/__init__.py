"""The worlds of the experiments: SDF writers, scenarios by name, and floor plans."""
