"""Cases that a configuration asks for."""
