"""The compiled inner loop that all algorithms share: a scan's normal form."""
