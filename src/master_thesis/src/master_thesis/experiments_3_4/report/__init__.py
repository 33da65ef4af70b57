"""The sections of Experiments 3 and 4 in the report, and the pieces behind them."""
