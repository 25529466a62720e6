"""
Modes of a structure
====================

The modes of a cantilever tube with a point mass and an empty damper, computed by finite elements from a configuration,
without the particles and with them.
"""

import warpdamp
from warpdamp.config.build import particle_mass
from warpdamp.modal.from_config import modes
from warpdamp.report.mode_shapes import shapes

config = warpdamp.load("../configs/cantilever.yaml")
loaded = modes(config, particles=particle_mass(config))
figure = shapes(loaded, config.title)

# %%
for particles in (0.0, particle_mass(config)):
    found = modes(config, particles=particles)
    print(f"{1e3 * particles:.1f} g of particles: {[f'{f:.2f} Hz' for f in found.frequency]}")
