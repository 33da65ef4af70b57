"""The shapes of bodies: triangle meshes, heightmaps, and collision shapes in PyBullet."""
