"""Links: relative poses of two scans that see the same surfaces."""
