"""Maps of short stretches of the path, and how one is placed on another."""
