"""Rust and cracks in photographs, placed on the surface."""
