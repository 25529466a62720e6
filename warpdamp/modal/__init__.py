"""From structures to modes, and from dissipated energy to modal damping and frequency response."""


class ModalError(ValueError):
    """What cannot be had from these results or this FRF; says why, and what to do."""
