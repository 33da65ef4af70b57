"""Compiled inner loops: slowness of cells, fast sweeping, shortest ways."""
