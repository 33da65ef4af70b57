"""The frame of the report: what a section holds, the thesis's own results to compare with, and the page."""
