"""A design problem of two modes in numbers, whose parts tests change."""

from warpdamp import load

STUDY = """\
structure:
  modes_given: [{{frequency: 40 Hz, modal_mass: 0.4 kg}}, {{frequency: 250 Hz, modal_mass: 0.6 kg, number: 3}}]
  particles_included: {included}
damper:
  enclosure: {{diameter: 40 mm, height: 40 mm, material: pmma_terzioglu}}
  particles: {{count: 60, radius: 3.73 mm, material: {material}}}
contact: {contact}
excitation: {{gamma: [2, 4]}}
design:
  target: {target}
  variables: {variables}
  limits: {limits}
"""


def study(tmp_path, **changes):
    given = {
        "included": "true",
        "material": "pmma_terzioglu",
        "contact": "{}",
        "target": "{damping: 1 %, modes: [1], gamma: [2, 6]}",
        "variables": "{enclosure.height: {from: 30 mm, to: 50 mm}, particles.count: {from: 20, to: 120}}",
        "limits": "{}",
    } | changes
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.format(**given))
    return load(path)
