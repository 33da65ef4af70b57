"""What `bench findings` measures on photographs of others."""
