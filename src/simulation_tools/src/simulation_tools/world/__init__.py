"""The physical world: PyBullet bodies and Embree rays."""
