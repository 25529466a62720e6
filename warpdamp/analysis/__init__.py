"""Analysis of finished results: Dataset in, Dataset or numbers out."""
