"""Pictures of maps of voxels."""
