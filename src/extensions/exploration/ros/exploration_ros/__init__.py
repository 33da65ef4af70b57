"""Shared by nodes that plan and explore: a planner's map, messages, markers, the held battery."""
