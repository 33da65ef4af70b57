"""What a closed loop does to the lidar: it fails, or it nods."""
