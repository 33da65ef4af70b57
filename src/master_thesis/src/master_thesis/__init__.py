"""The experiments of the thesis: worlds, flights, results, campaigns. See README.md."""
