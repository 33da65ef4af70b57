"""The driver of Experiments 3 and 4; it also watches the SLAM node."""
