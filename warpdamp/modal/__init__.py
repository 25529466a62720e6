"""From structures to modes, and from dissipated energy to modal damping and frequency response."""
