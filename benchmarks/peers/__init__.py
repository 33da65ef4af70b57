"""Other simulators, measured in the same run as ours. The packages of each are in .peers/NAME."""
