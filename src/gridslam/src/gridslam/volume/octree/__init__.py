"""OctoMap's streams and files."""
