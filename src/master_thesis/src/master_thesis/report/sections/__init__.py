"""The report's sections: each module turns the numbers of pieces into tables, pictures and findings."""
