"""The computations behind the report: a piece is one flight, one set of flights or one measurement."""
