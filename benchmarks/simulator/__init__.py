"""What the benchmarks `sim` and `px4` measure: the graph, the soaks, the step responses."""
