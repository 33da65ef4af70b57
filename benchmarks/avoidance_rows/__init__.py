"""What `avoidance` flies and how it judges: the rows of its table, their goals, and the random forests."""
