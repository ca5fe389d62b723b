"""Pages of results: one HTML file that needs nothing else, made from a folder of results."""
