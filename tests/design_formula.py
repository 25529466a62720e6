"""A design problem whose effectiveness is a formula instead of a simulation."""

import math
from contextlib import contextmanager

import numpy as np
import pytest

from warpdamp.design import search as searching
from warpdamp.design.cases import Row

PACKING, NOISE = 0.52, 0.04

STUDY = """\
structure:
  modes_given: [{frequency: 40 Hz, modal_mass: 0.4 kg}]
  particles_included: true
damper:
  enclosure: {diameter: 40 mm, height: 40 mm, material: pmma_terzioglu}
  particles: {count: 60, radius: 3.73 mm, material: pmma_terzioglu}
contact: {}
excitation: {gamma: [2, 4]}
design:
  target: {damping: 2 %, gamma: [2, 8]}
  variables:
    enclosure.height: {from: 25 mm, to: 50 mm}
    particles.count: {from: 60, to: 160}
  budget: {cases: 260}
"""


def effectiveness(config, frequency, gamma):
    """A curve with its optimum at the Gamma of eq. 1, log-normal in Gamma: as the true one, a bell."""
    cavity, particles = config.damper.enclosure, config.damper.particles
    fill = particles.count * 4 / 3 * math.pi * particles.radius**3 / (math.pi / 4 * cavity.diameter**2 * cavity.height)
    optimum = 4 * math.pi * frequency**2 * max(cavity.height * (1 - fill / PACKING), 1e-4) / 9.81
    return 0.8 * np.exp(-0.5 * (np.log(gamma / optimum) / 1.2) ** 2)


def simulated(problem, orders, store, *, workers, report):
    """Cases by the formula, each packing off by a little of its own; the same each time."""
    rows = []
    for order in orders:
        frequency = float(problem.modes(order.design).frequency[order.mode])
        config = order.design.config
        own = np.random.default_rng([order.seed, round(1e3 * order.gamma), config.damper.particles.count])
        value = effectiveness(config, frequency, order.gamma) * math.exp(NOISE * own.standard_normal())
        rows.append(Row(order, frequency, value, NOISE, 0.002, PACKING))
    return rows


@contextmanager
def by_formula():
    """Searches among 128 designs, whose cases are those of the formula."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(searching, "run_orders", simulated)
        patch.setattr(searching, "SAMPLE", 128)
        yield
