"""Compares the inputs of a node with each other. Each check tells one sentence, or what to leave out."""
