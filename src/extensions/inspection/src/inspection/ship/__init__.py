"""The ship's own frame: frames, strakes, sides, plates and areas, from a YAML file."""
