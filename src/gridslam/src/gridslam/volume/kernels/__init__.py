"""The volume's inner loops."""
