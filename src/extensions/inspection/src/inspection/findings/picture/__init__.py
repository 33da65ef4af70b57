"""Rust and cracks in the pixels of one photograph."""
