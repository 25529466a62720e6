"""How finely, how long and how surely a case is computed."""
