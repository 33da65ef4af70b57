"""The exploration on the page of the report."""
