"""MAVLink's mission protocol: missions and fences, up, down and in flight."""
