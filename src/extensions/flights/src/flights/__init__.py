"""Flights: worlds, the chain without ROS, judges, results, trials, campaigns, and what drivers need."""
