"""The camera, and where it was when it took a photograph."""
