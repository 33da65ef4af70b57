"""What this package's nodes share: messages, parameters."""
