"""The path as measured steps: how uncertain each step and each way is, and the poses that fit all edges."""
