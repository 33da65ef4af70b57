"""Which views are worth a flight: what they reveal, and where room for the UAV may be."""
