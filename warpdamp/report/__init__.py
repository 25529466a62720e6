"""Reports of results: figures and tables."""
