"""Judges a flight: what it touched, how it stopped, how far it kept from walls."""
