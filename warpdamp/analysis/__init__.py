"""What finished results say: Dataset in, Dataset or numbers out."""
