"""What all packages that fly a UAV share: errors, checks, geometry of poses, SLAM's correction."""
