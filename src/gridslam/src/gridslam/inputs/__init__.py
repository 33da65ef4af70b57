"""From lidars and odometry of any kind to what the filter takes."""
