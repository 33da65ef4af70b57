"""Worlds drawn at random, a new one for each seed: forests, hallways, dead ends, offices, things overhead."""
