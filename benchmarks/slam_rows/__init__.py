"""The rows of the benchmark `slam`: what is measured, and what is to be reached."""
