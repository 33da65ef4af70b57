"""What a real hold shows: welds, dirt, runs of rust, wet plates. All are off by default."""
