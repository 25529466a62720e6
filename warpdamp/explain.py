"""What a study will simulate, why, and what it will take: told before anything runs."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from .config import Config
from .effects import Effects, called_for
from .scene import STANDARD_GRAVITY
from .sweep import as_list, grains

if TYPE_CHECKING:
    from .shaking import Spec

CALLS_FOR = {
    "friction": ("contact.friction", "contact.walls.friction"),
    "rotation": ("contact.friction", "contact.walls.friction"),
    "dashpots": ("contact.restitution", "contact.walls.restitution"),
    "rolling": ("contact.rolling_friction", "contact.walls.rolling_friction"),
    "gravity": ("excitation.gravity",),
    "side": ("damper.enclosure.side", "damper.enclosure"),
    "floor": ("damper.enclosure.floor", "damper.enclosure"),
    "lid": ("damper.enclosure.lid", "damper.enclosure"),
    "sizes": ("damper.particles",),
    "materials": ("damper.particles",),
    "channels": ("effects.ledger",),
}
"""Keys of the configuration that call for an effect."""

NOT_MODELLED = (
    "the structure's answer to the damper (the enclosure's motion is prescribed)",
    "air, cohesion, liquid bridges, electrostatic charge",
    "wear, breakage, plastic flow and heating of the particles",
    "particles that are no spheres; friction against spinning about the normal",
    "flexibility of the enclosure's walls",
)

PROCESS_MEMORY = 0.3e9
"""Of a worker process before any case, bytes (measured: Python, Warp, numpy, scipy, xarray)."""


@dataclass(frozen=True)
class Explanation:
    """An effect: whether it is simulated, the line that calls for it, and what it costs.

    Parameters
    ----------
    name : str
    on : bool
    why : str
    cost : float or None
        Nanoseconds per particle-step beside all others that are on, on the same contacts, as last measured on this
        machine.
    """

    name: str
    on: bool
    why: str
    cost: float | None


def effects_of(config: Config, spec: Spec) -> list[Explanation]:
    """Every effect of a case."""
    from .speed import TOGGLES, frozen, recall, without

    effects = spec.effects
    called = called_for(spec.scene, spec.bed.grains, precision=effects.precision)
    forced = dict(spec.bed.numerics.forced)
    explained = []
    for field in fields(Effects):
        name = field.name
        if name in ("precision", "guards", "structure"):
            continue
        on = getattr(effects, name)
        why = _why(config, name, on)
        if name in forced and on != getattr(called, name):
            why = f"forced {'on' if on else 'off'}, though the scene {'calls' if not on else 'does not call'} for it"
        full = recall(frozen, effects)
        less = recall(frozen, without(effects, name)) if name in TOGGLES else None
        cost = full - less if on and full is not None and less is not None else None
        explained.append(Explanation(name, on, why, cost))
    return explained


def _why(config: Config, name: str, on: bool) -> str:
    if name in ("sizes", "materials"):
        own = grains(config)
        count = len(set(own.radius if name == "sizes" else own.species))
        what = {"sizes": "radius", "materials": "material"}[name]
        return _line(
            config, "damper.particles", f"{count} {what if count == 1 else {'radius': 'radii'}.get(what, what + 's')}"
        )
    values = config.model_dump()
    shown = []
    for key in CALLS_FOR[name]:
        value = _value(values, key)
        if value is not None and not isinstance(value, dict) and not (shown and key == CALLS_FOR[name][-1]):
            shown.append(_line(config, key, str(value)))
    if not shown:
        return _line(config, CALLS_FOR[name][-1], "on" if on else "off")
    if name == "rotation" and on:
        return "friction turns particles: " + ", ".join(shown)
    return ", ".join(shown)


def _value(node, key: str):
    for part in key.split("."):
        node = node.get(part) if isinstance(node, dict) else None
    return node


def _line(config: Config, key: str, value: str) -> str:
    place = config.line(key)
    return f"{key}: {value} ({f'line {place}' if place else 'default'})"


def explain(config: Config, *, workers: int | None = None) -> str:
    """The plan of a study in words: effects, step, cases, time, memory, and what is not modelled."""
    from .study import every_spec
    from .tolerance import applied

    config = applied(config)
    specs = list(every_spec(config).values())
    sets: dict[Effects, Spec] = {}
    for spec in specs:
        sets.setdefault(spec.effects, spec)
    blocks = [config.title]
    for number, (effects, spec) in enumerate(sets.items(), 1):
        count = sum(s.effects == effects for s in specs)
        heading = "Effects" if len(sets) == 1 else f"Effects, set {number} of {len(sets)} ({count} cases)"
        blocks.append("\n".join([heading, *_effects_table(config, spec), _precision(effects)]))
    blocks.append("\n".join(["Step", *_steps(specs)]))
    blocks.append("\n".join(["Cases", *_cases(config, specs)]))
    blocks.append("\n".join(["Time and memory", *_price(config, specs, workers or os.cpu_count())]))
    blocks.append("\n".join(["Not modelled", *(f"  {item}" for item in NOT_MODELLED)]))
    return "\n\n".join(blocks)


def _effects_table(config, spec):
    rows = effects_of(config, spec)
    yield f"  {'':10} {'':4} {'ns per particle-step':>20}  because"
    for row in rows:
        cost = "" if row.cost is None else f"{row.cost:.1f}"
        yield f"  {row.name:10} {'on' if row.on else 'off':4} {cost:>20}  {row.why}"


def _precision(effects: Effects) -> str:
    return f"  motion in {effects.precision}, energies in float64"


def _steps(specs):
    from .timestep import expected_speed, shortest_contact

    finest = min(specs, key=lambda s: s.dt)
    coarsest = max(specs, key=lambda s: s.dt)
    for spec in dict.fromkeys((finest, coarsest)):
        drive = spec.scene.drive
        speed = expected_speed(spec.scene, spec.bed.grains.radius)
        contact = shortest_contact(spec.scene, spec.bed.grains, speed)
        yield (
            f"  {1e6 * spec.dt:.3g} us at {drive.frequency:.4g} Hz, Gamma {drive.acceleration / STANDARD_GRAVITY:.3g}: "
            f"{spec.steps_per_cycle} steps a cycle; the shortest contact expected takes {1e6 * contact:.3g} us "
            f"({contact / spec.dt:.0f} steps) at {speed:.3g} m/s"
        )


def _cases(config, specs):
    beds = {spec.bed.key() for spec in specs}
    gammas = as_list(config.excitation.gamma)
    yield f"  {len(specs)} cases, Gamma {min(gammas):g} to {max(gammas):g}; {len(beds)} {config.preparation} beds"
    sizes = [len(spec.bed.grains) for spec in specs]
    yield f"  {min(sizes)} particles each" if min(sizes) == max(sizes) else f"  {min(sizes)} to {max(sizes)} particles"


def _price(config, specs, workers):
    from .speed import moving, recall
    from .study import BATCH, criteria_of

    least = sum(spec.cost(criteria_of(config, spec)) for spec in specs)
    most = least * config.steady_state.most_cycles / config.steady_state.fewest_cycles
    rates = [recall(moving, spec.effects) for spec in specs]
    yield f"  at least {least:.3g} particle-steps, at most {most:.3g} if no case becomes steady; beds are extra"
    if None in rates:
        yield "  this machine's speed is not measured yet: warpdamp explain --measure takes half a minute"
    else:
        spent = sum(spec.cost(criteria_of(config, spec)) * rate * 1e-9 for spec, rate in zip(specs, rates, strict=True))
        yield (
            f"  {np.mean(rates):.0f} ns per particle-step on this machine: at least {_duration(spent / workers)} on "
            f"{workers} cores, at most {_duration(spent / workers * most / least)}"
        )
    largest = max(specs, key=lambda s: len(s.bed.grains))
    case = particle_bytes(largest.effects) * len(largest.bed.grains) + row_bytes(largest.effects) * (
        config.steady_state.most_cycles + 1
    )
    yield f"  about {(PROCESS_MEMORY + BATCH * case) / 1e6:.0f} MB for each of {workers} processes"


def particle_bytes(effects: Effects) -> int:
    """What a particle takes on the device with its contacts, eight neighbours listed twice."""
    from .kernels.data import types

    t = types(effects)
    pair = sum(_size(v) for name, v in t.Contacts.vars.items() if name == "partner" or name.startswith("pair_"))
    wall = 3 * sum(_size(v) for name, v in t.Contacts.vars.items() if name.startswith("wall_") and "laws" not in name)
    return np.dtype(t.Particle.numpy_dtype()).itemsize + 8 * pair + wall


def row_bytes(effects: Effects) -> int:
    """What a cycle's row of the ledger takes."""
    from .kernels.data import columns

    return 8 * len(columns(effects))


def _size(variable) -> int:
    import warp as wp

    return wp.types.type_size_in_bytes(variable.type.dtype)


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
