"""What the report says: from the pieces' numbers to tables, pictures and findings, one module a section."""
