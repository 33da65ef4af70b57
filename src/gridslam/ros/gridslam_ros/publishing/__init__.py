"""What the node slam_gridslam tells others: maps, its state, map -> odom."""
