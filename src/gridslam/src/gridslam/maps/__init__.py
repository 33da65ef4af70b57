"""Every particle's map, in tiles that particles share."""
