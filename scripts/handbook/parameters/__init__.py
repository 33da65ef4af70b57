"""Which parameters the nodes read, and what each means: read in the sources, which are not imported."""
