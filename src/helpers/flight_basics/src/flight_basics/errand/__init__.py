"""An errand: a goal that a UAV flies. Messages come in, outputs go out; no ROS, and no locks."""
