"""The maps of voxels of Experiments 3 and 4: of a flight's results, and of the report."""
