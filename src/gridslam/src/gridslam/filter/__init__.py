"""The particle filter: motion, matching, proposal, weights, and the maps that particles share."""
