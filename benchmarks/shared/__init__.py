"""What several benchmarks use: results, trials, places, anchors."""
