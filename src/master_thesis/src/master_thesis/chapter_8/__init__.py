"""The report's command: all of chapter 8, computed in one call and written as one page."""
