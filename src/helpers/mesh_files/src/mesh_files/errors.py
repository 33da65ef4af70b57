"""What this package raises."""


class MeshFileError(Exception):
    """A mesh file that cannot be used: what is wrong with it, in words without the file's name."""
