"""What each scan says about the pose: whether the state is tracking, drifting, uncertain or lost."""
