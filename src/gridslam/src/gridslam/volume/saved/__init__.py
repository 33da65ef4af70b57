"""The complete state of a map of voxels, to go on with it, also in another flight."""
