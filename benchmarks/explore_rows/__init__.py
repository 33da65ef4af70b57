"""The rows of `bench explore`: places, and one flight in each."""
