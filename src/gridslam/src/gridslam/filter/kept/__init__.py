"""What is kept of processed scans: all of them, only their poses, or an earlier map."""
