"""A simulator for multirotors that carry a lidar, with a stand-in for PX4. See README.md."""
