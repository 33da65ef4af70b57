"""The nodes that lead the experiments: they follow the flight, give orders, and write the results."""
