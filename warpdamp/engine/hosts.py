"""Transfer of a batch's host structures to the device and back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import warp as wp

from ..scene.host import HostStructure

if TYPE_CHECKING:
    from .batch import Case

SAME = ("frequency", "damping", "direction", "force", "base", "participation", "position", "velocity", "record")
"""Fields of the hosts of cases on one structure that are the same."""

AT_REST = {"excitation": 0.0, "base_moves": 0, "samples": 0}


def shared(cases: Sequence[Case], enclosures: Sequence[int] | None) -> tuple[int, ...]:
    """Number of cases on the structure of each case, which are those from it on; 0 for those after the first.

    Raises
    ------
    ValueError
        If the numbers do not add up, or cases on one structure differ in it or in their step.
    """
    if enclosures is None:
        return (1,) * len(cases)
    if min(enclosures) < 1 or sum(enclosures) != len(cases):
        raise ValueError(f"enclosures: {tuple(enclosures)} are not {len(cases)} cases, each on one structure")
    found: list[int] = []
    for count in enclosures:
        first = cases[len(found)]
        for case in cases[len(found) + 1 : len(found) + count]:
            _check_same(first, case)
        found += [count, *[0] * (count - 1)]
    return tuple(found)


def _check_same(first: Case, case: Case) -> None:
    """Check that two cases sit on the same structure and take the same steps."""
    one, other = first.scene.host, case.scene.host
    if one is None or other is None:
        raise ValueError("enclosures: a case without a host structure cannot share one")
    differ = [name for name in SAME if getattr(one, name) != getattr(other, name)]
    differ += [name for name in ("dt", "steps_per_cycle") if getattr(first, name) != getattr(case, name)]
    if differ:
        raise ValueError(f"enclosures: cases on one structure differ in {' and '.join(differ)}")


class HostStructures:
    """Modes, excitations and records of a batch's host structures, collected for the device."""

    def __init__(self):
        self.modes: list[dict[str, float]] = []
        self.amplitudes: list[float] = []
        self.signal: list[float] = []
        self.records = 0
        self.cases = 0

    def add(self, host: HostStructure | None, dt: float, most_records: int, enclosures: int = 1) -> dict:
        """Fields of the device's Case for one case.

        Parameters
        ----------
        host : HostStructure or None
            None: no modes, so that the enclosure rests.
        dt : [s]
        most_records : int
        enclosures : int
            How many of the cases, from this one on, sit on its structure; 0: it sits on that of the case before.
        """
        self.cases += 1
        fields = {
            "enclosures": enclosures,
            "first_mode": len(self.modes),
            "first_amplitude": len(self.amplitudes),
            "first_sample": len(self.signal),
            "first_record": self.records,
        }
        if host is None:
            return fields | {"modes": 0, **AT_REST, "sample_step": dt, "record": 0, "records": 0}
        self.amplitudes += host.amplitude
        self.records += most_records if host.record else 0
        fields |= {
            "modes": len(host.frequency),
            "record": host.record,
            "records": most_records if host.record else 0,
        }
        if not enclosures:
            return fields | {"first_mode": len(self.modes) - len(host.frequency), **AT_REST, "sample_step": dt}
        gammas = host.participation if host.base else (0.0,) * len(host.frequency)
        for f, zeta, gamma, q, v in zip(
            host.frequency, host.damping, gammas, host.position, host.velocity, strict=True
        ):
            w = 2 * math.pi * f
            self.modes.append(
                {"stiffness": w**2, "damping": zeta * w, "participation": gamma, "position": q, "velocity": v}
            )
        signal = host.excitation
        samples = [] if signal is None or signal.samples is None else np.asarray(signal.samples, float).tolist()
        self.signal += samples
        return fields | {
            "excitation": signal.amplitude if signal else 0.0,
            "base_moves": int(host.base is not None),
            "samples": len(samples),
            "sample_step": signal.sample_step if samples else dt,
        }

    def on_device(self, types, device: str):
        """Struct of the host structures of all cases on the device."""
        host = types.HostStructure()
        host.count = len(self.modes)
        if "modes" in types.HostStructure.vars:
            modes = np.zeros(len(self.modes), dtype=types.Mode.numpy_dtype())
            for name in self.modes[0] if self.modes else ():
                modes[name] = [mode[name] for mode in self.modes]
            host.modes = wp.array(modes, dtype=types.Mode, device=device)
            host.amplitudes = wp.array(self.amplitudes or [0.0], dtype=types.real, device=device)
            host.enclosures = wp.zeros(self.cases, dtype=types.Enclosure, device=device)
            host.signal = wp.array(self.signal or [0.0], dtype=types.real, device=device)
            host.records = wp.full(max(1, self.records), wp.vec3d(math.nan), dtype=wp.vec3d, device=device)
        return host
