"""The particle filter: motion, matching, proposal, weights."""
