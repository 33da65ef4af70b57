"""The surface that is to be photographed, in patches, and the room in which the UAV flies."""
