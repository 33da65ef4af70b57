"""The nodes that control the experiments: they watch the flight, give orders, and write the results."""
