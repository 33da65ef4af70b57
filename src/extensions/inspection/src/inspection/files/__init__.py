"""Files of an inspection: tables that people write, and files that are whole or not there."""
