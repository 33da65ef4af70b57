"""The ways out of an emergency, and from under what sinks."""
