"""Hard cases: each runs, stays finite, contained and closed in energy, or is refused before it starts."""
