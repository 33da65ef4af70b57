"""From where each patch can be seen, and a small set of photographs that shows them."""
