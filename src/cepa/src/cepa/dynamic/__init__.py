"""CEPA that knows what it flies: candidates rolled through the UAV's response, memory, ways out."""
