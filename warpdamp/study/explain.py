"""Explanation of a study before it runs: what is simulated, why, and what it takes."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..config.build import grains
from ..config.preparation import carried_path, preparation_word, state_asked
from ..config.study import Config
from ..coupled.run import planned
from ..errors import ConfigError
from ..execution.adaptive import needed_cases
from ..execution.batching import BATCH_COST, MOST_CASES
from ..execution.progress import duration
from ..execution.store import Finished
from ..numerics.timestep import expected_speed, shortest_contact
from ..scene.effects import EFFECTS, NOT_MODELLED, Effects, called_for
from ..scene.scene import STANDARD_GRAVITY
from ..scene.shape import SHAPES, aspects
from ..sweep.cases import Cases
from ..sweep.plan import Fate, make_plan
from ..sweep.resolve import self_contained, with_tolerance
from .several import studies
from .speeds import TOGGLES, recall, without

if TYPE_CHECKING:
    from ..damper.case import Spec
    from ..modes import Modes
    from ..sweep.plan import Plan

LISTED_PAIRS = 8
"""Listed pairs to a particle: three or four near it, and as many while a new list is made beside the old one."""

PROCESS_MEMORY = 0.3e9
"""Memory of a worker process before any case [bytes]: 236 to 251 MB were measured, rounded up."""


@dataclass(frozen=True)
class Explanation:
    """Explanation of an effect: whether it is simulated, the line that requires it, and its cost.

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
    """Explanations of all effects of a case."""
    effects = spec.effects
    called = called_for(spec.scene, spec.bed.grains, precision=effects.precision, device=effects.device)
    forced = dict(spec.bed.numerics.forced)
    explained = []
    for name in (name for name, effect in EFFECTS.items() if effect.keys):
        on = getattr(effects, name)
        why = _aspects(config, spec) if name in SHAPES else _why(config, name, on)
        if name in forced and on != getattr(called, name):
            why = f"forced {'on' if on else 'off'}, though the scene {'calls' if not on else 'does not call'} for it"
        full = recall("frozen", effects)
        less = recall("frozen", without(effects, name)) if name in TOGGLES else None
        cost = full - less if on and full is not None and less is not None else None
        explained.append(Explanation(name, on, why, cost))
    return explained


def _aspects(config: Config, spec: Spec) -> str:
    """Aspects of a case's particles, and the line that has them, or their list."""
    key = "damper.particles" if isinstance(config.damper.particles, list) else "damper.particles.shape.aspect"
    different = sorted(set(aspects(spec.bed.grains).tolist()))
    return _line(config, key, ", ".join(f"{aspect:g}" for aspect in different))


def _why(config: Config, name: str, on: bool) -> str:
    effect = EFFECTS[name]
    if effect.counted:
        attribute, singular, plural = effect.counted
        count = len(set(getattr(grains(config), attribute)))
        return _line(config, effect.keys[0], f"{count} {singular if count == 1 else plural}")
    values = config.model_dump()
    shown = []
    for key in effect.keys:
        value = _value(values, key)
        if value is not None and not isinstance(value, dict) and not (shown and key == effect.keys[-1]):
            shown.append(_line(config, key, str(value)))
    if not shown:
        return _line(config, effect.keys[-1], "on" if on else "off")
    return (effect.because if on else "") + ", ".join(shown)


def _value(node, key: str):
    for part in key.split("."):
        node = node.get(part) if isinstance(node, dict) else None
    return node


def _line(config: Config, key: str, value: str) -> str:
    if config._source is None:
        return f"{key}: {value}"
    place = config.line(key)
    return f"{key}: {value} ({f'line {place}' if place else 'default'})"


def explain(config: Config, *, workers: int | None = None) -> str:
    """Explanation of a study as text: effects, step, cases, time, memory, and what is not modelled.

    Of several dampers that of each, one after the other.
    """
    if config.dampers:
        own, seen = studies(config)
        heads = [_damper(k, modes) for k, modes in enumerate(seen, 1)]
        plans = [explain(study, workers=workers) for study in own]
        blocks = [config.title, *(text for pair in zip(heads, plans, strict=True) for text in pair)]
        return "\n\n".join([*blocks, *_coupled(config)])
    written = config
    config = with_tolerance(self_contained(config))
    plan = make_plan(Cases(config))
    numbers = plan.to_run()
    sets: dict[Effects, list[int]] = {}
    for group, (effects, _) in enumerate(plan.groups):
        sets.setdefault(effects, []).extend(numbers[plan.group[numbers] == group])
    blocks = [config.title]
    for k, (effects, members) in enumerate(sets.items(), 1):
        spec, _ = plan.cases.spec(int(members[0]))
        heading = "Effects" if len(sets) == 1 else f"Effects, set {k} of {len(sets)} ({len(members)} cases)"
        blocks.append("\n".join([heading, *_effects_table(config, spec), _precision(effects)]))
    blocks.append("\n".join(["Step", *_steps(plan, numbers)]))
    blocks.append("\n".join(["Cases", *_cases(plan, numbers)]))
    blocks.append("\n".join(["Time and memory", *_price(plan, numbers, workers or os.cpu_count())]))
    blocks.append("\n".join(["Not modelled", *(f"  {item}" for item in NOT_MODELLED)]))
    blocks += _coupled(written)
    return "\n\n".join(blocks)


def _coupled(config: Config) -> list[str]:
    """What `warpdamp coupled` will run, or why it refuses; nothing where the configuration has no such section."""
    if config.coupled is None:
        return []
    lines = ["Coupled runs (warpdamp coupled)"]
    try:
        runs, _ = planned(config)
    except ConfigError as error:
        return ["\n".join([*lines, f"  are refused: {error}"])]
    run, counts = runs[0, 0], f"levels {len(config.coupled.levels)}, seeds {len(config.seeds)}"
    particles = sum(len(bed.grains) for bed in run.beds)
    dampers = f", {len(run.beds)} dampers each" if len(run.beds) > 1 else ""
    lines.append(f"  runs: {len(runs)} ({counts}) of {config.coupled.duration:g} s by {config.coupled.source}{dampers}")
    lines.append(f"  {1e6 * run.dt:.3g} us a step, {run.steps} steps, recorded every {run.host.record}")
    lines.append(f"  {len(runs) * run.steps * particles:.3g} particle-steps; beds are extra")
    return ["\n".join(lines)]


def _damper(number: int, modes: Modes) -> str:
    """Where one of several dampers sits, as the modes show it."""
    shape = ", ".join(f"{phi:.4g} in mode {n}" for n, phi in zip(modes.number, modes.amplitude, strict=True))
    return f"Damper {number}: mass-normalised shape {shape} (kg^-1/2)"


def _effects_table(config, spec):
    rows = effects_of(config, spec)
    yield f"  {'':10} {'':4} {'ns per particle-step':>20}  because"
    for row in rows:
        cost = "" if row.cost is None else f"{row.cost:.1f}"
        yield f"  {row.name:10} {'on' if row.on else 'off':4} {cost:>20}  {row.why}"


def _precision(effects: Effects) -> str:
    return f"  motion in {effects.precision}, energies in float64, on the device {effects.device}"


def _steps(plan: Plan, numbers):
    dt = plan.dt[numbers]
    for number in dict.fromkeys((int(numbers[dt.argmin()]), int(numbers[dt.argmax()]))):
        spec, _ = plan.cases.spec(number)
        drive = spec.scene.drive
        speed = expected_speed(spec.scene, spec.bed.grains.radius)
        contact = shortest_contact(spec.scene, spec.bed.grains, speed)
        yield (
            f"  {1e6 * spec.dt:.3g} us at {drive.frequency:.4g} Hz, Gamma {drive.acceleration / STANDARD_GRAVITY:.3g}: "
            f"{spec.steps_per_cycle} steps a cycle; the shortest contact expected takes {1e6 * contact:.3g} us "
            f"({contact / spec.dt:.0f} steps) at {speed:.3g} m/s"
        )


def _cases(plan: Plan, numbers):
    cases = plan.cases
    amplitudes = "" if np.isnan(cases.gammas[0]) else f", Gamma {min(cases.gammas):g} to {max(cases.gammas):g}"
    yield f"  {len(numbers)} cases{amplitudes}; {_beds(cases, len(plan.beds))}"
    if cases.config.accuracy is not None:
        first = len(needed_cases(plan, Finished()))
        yield f"  of these {first} at first, and more packings of a point until it is within the tolerance"
    if cases.config.sweep:
        lengths = " x ".join(f"{n} {name}" for name, n in zip(cases.dims, cases.shape, strict=True) if n > 1)
        left_out = [
            f"{np.sum(plan.fate == fate)} {name}"
            for fate, name in ((Fate.EXCLUDED, "excluded"), (Fate.REFUSED, "impossible"))
            if np.any(plan.fate == fate)
        ]
        yield f"  {lengths or '1'}{''.join(f', without {text}' for text in left_out)}"
    low, high = plan.particles[numbers].min(), plan.particles[numbers].max()
    yield f"  {low} particles each" if low == high else f"  {low} to {high} particles"
    modes = next(cases.points()).modes
    if modes is not None and modes.remark:
        yield f"  {modes.remark}"


def _beds(cases: Cases, count: int) -> str:
    """Words for the beds: how they are prepared, to what, and the way that they are carried, unless that is swept."""
    preparation, swept = cases.config.preparation, cases.names().values()
    noun = "bed" if count == 1 else "beds"
    if "preparation" in swept:
        return f"{count} {noun}"
    path, beds = carried_path(preparation), f"{count} {preparation_word(preparation)} {noun}"
    for name, value in state_asked(preparation).items():
        text = "" if f"preparation_{name}" in swept else f"{1e3 * value:g} mm" if name == "clearance" else f"{value:g}"
        return f"{beds}: {text}" if text else beds
    return f"{beds}, each through all amplitudes {', then '.join(path)}" if path else beds


def _price(plan: Plan, numbers, workers):
    cost, group = plan.cost[numbers], plan.group[numbers]
    first = np.isin(numbers, needed_cases(plan, Finished()))
    longer = np.array([criteria.most / criteria.fewest for _, criteria in plan.groups])
    least, most = cost[first].sum(), (cost * longer[group]).sum()
    yield f"  at least {least:.3g} particle-steps, at most {most:.3g} if no case becomes steady; beds are extra"
    rates = [recall("moving", effects) for effects, _ in plan.groups]
    if None in rates:
        yield "  this machine's speed is not measured yet: warpdamp explain --measure takes about a minute"
    else:
        spent = float((cost * np.array(rates)[group])[first].sum()) * 1e-9
        yield (
            f"  {np.mean(rates):.0f} ns per particle-step on this machine: at least {duration(spent / workers)} on "
            f"{workers} cores, at most {duration(spent / workers * most / least)}"
        )
    largest = int(plan.particles[numbers].max())
    effects, criteria = plan.groups[0]
    case = case_bytes(effects, largest, criteria.most + 1)
    batch = max(1, min(MOST_CASES, BATCH_COST / cost.mean()))
    yield f"  about {(PROCESS_MEMORY + batch * case) / 1e6:.0f} MB for each of {workers} processes"


def case_bytes(effects: Effects, particles: int, rows: int) -> float:
    """Memory of a case on the device, with ``rows`` ledger rows [bytes]."""
    from ..engine.memory import particle_bytes
    from ..kernels.structs import types

    t = types(effects)
    return particles * particle_bytes(t, LISTED_PAIRS) + rows * 8 * len(t.columns)
