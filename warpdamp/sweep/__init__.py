"""Which cases a configuration asks for."""
