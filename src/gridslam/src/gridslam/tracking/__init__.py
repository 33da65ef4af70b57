"""What each scan says about the pose: whether the vehicle is tracked, or lost."""
