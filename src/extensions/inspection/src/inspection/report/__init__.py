"""The report of an inspection: grades, comparison with the last survey, and a page for the surveyor."""
