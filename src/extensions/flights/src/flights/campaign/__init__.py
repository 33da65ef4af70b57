"""Campaigns: many flights of the whole chain without ROS, on all cores or on a cluster, judged together."""
