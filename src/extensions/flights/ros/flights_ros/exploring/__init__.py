"""The node that controls an exploration."""
