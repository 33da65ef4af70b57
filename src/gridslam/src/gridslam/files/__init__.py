"""Maps, trajectories and the complete state of SLAM as files."""
