"""The doctor's ears: a running graph or a bag, turned into its plain snapshot."""
