"""The cost-to-go: how long the shortest way is from each place, out of the window or to the goal."""
