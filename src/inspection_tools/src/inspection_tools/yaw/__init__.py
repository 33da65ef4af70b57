"""Which way the UAV looks: the regulator, and the stamps of its messages."""
