"""What the report is computed from: each piece is one flight, one set of flights or one measurement."""
