"""What this package's nodes share: conversions of messages, parameters and frames."""
