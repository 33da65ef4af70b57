"""Compares the inputs of a node with each other. Each check tells a sentence, or what to leave out."""
