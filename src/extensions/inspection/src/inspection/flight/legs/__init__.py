"""The legs of an inspection: the ways to photographs, and the flight to one or past it."""
