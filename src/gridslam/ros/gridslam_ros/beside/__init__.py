"""What comes on other topics than a scan, and belongs to it."""
