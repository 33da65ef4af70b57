"""The errors of a map of voxels against true surfaces."""
