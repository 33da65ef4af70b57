"""The inner loops of the cloud odometry."""
