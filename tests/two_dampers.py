"""Configuration of two dampers on a structure whose modes are given."""

GIVEN = """
structure:
  modes_given: [{frequency: 40 Hz, modal_mass: 500 g, damping: 1 %}, {frequency: 90 Hz, modal_mass: 800 g}]
  particles_included: true
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 8, radius: 3.73 mm, material: pmma}
dampers:
  - enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
    particles: {count: 8, radius: 3.73 mm, material: pmma}
    amplitude: [PHI kg^-0.5, 0]
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 33 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [2, 4]}
preparation: loose
steady_state: {fewest_cycles: 8, most_cycles: 8}
"""
"""PHI stands for the mode's shape at the second damper."""
