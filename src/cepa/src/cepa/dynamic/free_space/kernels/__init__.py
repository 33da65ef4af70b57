"""Compiled inner loops: ends of beams, free ranges, pictures of clouds, cells that were seen free."""
