"""Where base and lidar were, by TF."""
