"""Properties of particles and pairs: constants of the case where all are alike, arrays otherwise."""

import functools
from types import SimpleNamespace

import warp as wp

from .structs import types


@functools.cache
def particles(effects):
    """Return the properties of particles, pairs and walls for the given effects."""
    t = types(effects)
    real = t.real
    Case, Particle, Contacts = t.Case, t.Particle, t.Contacts

    @wp.func
    def radius_of(case: Case, p: wp.array(dtype=Particle), i: int):
        """Radius of particle i [m]."""
        if wp.static(effects.sizes):
            return p[i].radius
        else:
            return case.particle_radius

    @wp.func
    def inverse_mass_of(case: Case, p: wp.array(dtype=Particle), i: int):
        """Inverse of the mass of particle i [1/kg]."""
        if wp.static(effects.alike):
            return case.inverse_mass
        else:
            return p[i].inverse_mass

    @wp.func
    def inverse_inertia_of(case: Case, p: wp.array(dtype=Particle), i: int):
        """Inverse of the moment of inertia of particle i [1/(kg m^2)]."""
        if wp.static(effects.alike):
            return case.inverse_inertia
        else:
            return p[i].inverse_inertia

    @wp.func
    def reduced_radius(case: Case, p: wp.array(dtype=Particle), i: int, j: int):
        """Reduced radius R* of a pair [m]."""
        if wp.static(effects.sizes):
            return p[i].radius * p[j].radius / (p[i].radius + p[j].radius)
        else:
            return real(0.5) * case.particle_radius

    @wp.func
    def curvature(case: Case, p: wp.array(dtype=Particle), i: int, j: int):
        """Curvature 1 / R* of a pair [1/m]."""
        if wp.static(effects.sizes):
            return (p[i].radius + p[j].radius) / (p[i].radius * p[j].radius)
        else:
            return real(2.0) * case.particle_curvature

    @wp.func
    def wall_curvature(case: Case, p: wp.array(dtype=Particle), i: int):
        """Curvature 1 / R* of a particle and a wall [1/m]."""
        if wp.static(effects.sizes):
            return real(1.0) / p[i].radius
        else:
            return case.particle_curvature

    @wp.func
    def reduced_mass(case: Case, p: wp.array(dtype=Particle), i: int, j: int):
        """Reduced mass m* of a pair [kg]."""
        if wp.static(effects.alike):
            return real(0.5) / case.inverse_mass
        else:
            return real(1.0) / (p[i].inverse_mass + p[j].inverse_mass)

    @wp.func
    def lever_arm(case: Case, p: wp.array(dtype=Particle), i: int, j: int, distance: real):
        """Distance of i's centre from the contact: the centres' distance shared in the ratio of the radii [m]."""
        if wp.static(effects.sizes):
            return p[i].radius * distance / (p[i].radius + p[j].radius)
        else:
            return real(0.5) * distance

    @wp.func
    def pair_law(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int, j: int):
        """Contact law of a pair."""
        if wp.static(effects.materials):
            return c.laws[case.first_law + case.species * p[i].species + p[j].species]
        else:
            return case.particle_law

    @wp.func
    def wall_law(case: Case, p: wp.array(dtype=Particle), c: Contacts, i: int):
        """Law of a particle and the walls."""
        if wp.static(effects.materials):
            return c.wall_laws[case.first_wall_law + p[i].species]
        else:
            return case.wall_law

    return SimpleNamespace(
        radius_of=radius_of,
        inverse_mass_of=inverse_mass_of,
        inverse_inertia_of=inverse_inertia_of,
        reduced_radius=reduced_radius,
        curvature=curvature,
        wall_curvature=wall_curvature,
        reduced_mass=reduced_mass,
        lever_arm=lever_arm,
        pair_law=pair_law,
        wall_law=wall_law,
    )
