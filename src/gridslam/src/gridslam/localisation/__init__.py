"""Judges whether the vehicle is where SLAM thinks it is, and finds it when it is lost."""
