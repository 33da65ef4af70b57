"""What the drivers of all experiments share: they watch a run, give orders, and write the results."""
