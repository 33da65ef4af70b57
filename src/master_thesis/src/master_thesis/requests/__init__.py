"""What is asked for: of a driver by its parameters, of a launch file by its arguments, checked alike."""
