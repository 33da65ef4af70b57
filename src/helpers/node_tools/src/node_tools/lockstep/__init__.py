"""What nodes tell the simulator in lockstep."""
