"""What SLAM's poses are good for: whether one is sure, and whether a jump of it lasts."""
