"""The nodes that control the experiments: they follow the flight, give orders, and write the results."""
