"""The measurements of the benchmarks `sim` and `px4`: the graph, the soaks, the step responses."""
