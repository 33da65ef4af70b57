"""The report: the thesis's chapter 8, computed in one call and shown beside the thesis's own results."""
