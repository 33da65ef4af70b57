"""Reads a running graph or a bag into the doctor's plain snapshot."""
