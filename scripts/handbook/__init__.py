"""Builds the handbook: a folder of HTML pages from Markdown pages, parameters and docstrings."""
