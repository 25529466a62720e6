"""Transfer of a batch's host structures to the device and back."""

from __future__ import annotations

import math

import numpy as np
import warp as wp

from ..scene.host import HostStructure

AT_REST = {"excitation": 0.0, "base_moves": 0, "samples": 0}


class HostStructures:
    """Modes, excitations and records of a batch's host structures, collected for the device."""

    def __init__(self):
        self.modes: list[dict[str, float]] = []
        self.signal: list[float] = []
        self.records = 0

    def add(self, host: HostStructure | None, dt: float, most_records: int) -> dict:
        """Fields of the device's Case for one case.

        Parameters
        ----------
        host : HostStructure or None
            None: no modes, so that the enclosure rests.
        dt : [s]
        most_records : int
        """
        fields = {"first_mode": len(self.modes), "first_sample": len(self.signal), "first_record": self.records}
        if host is None:
            return fields | {"modes": 0, **AT_REST, "sample_step": dt, "record": 0, "records": 0}
        gammas = host.participation if host.base else (0.0,) * len(host.frequency)
        for f, zeta, phi, gamma, q, v in zip(
            host.frequency, host.damping, host.amplitude, gammas, host.position, host.velocity, strict=True
        ):
            w = 2 * math.pi * f
            shape = {"stiffness": w**2, "damping": zeta * w, "amplitude": phi, "participation": gamma}
            self.modes.append(shape | {"position": q, "velocity": v})
        signal = host.excitation
        samples = [] if signal is None or signal.samples is None else np.asarray(signal.samples, float).tolist()
        self.signal += samples
        self.records += most_records if host.record else 0
        return fields | {
            "modes": len(host.frequency),
            "excitation": signal.amplitude if signal else 0.0,
            "base_moves": int(host.base is not None),
            "samples": len(samples),
            "sample_step": signal.sample_step if samples else dt,
            "record": host.record,
            "records": most_records if host.record else 0,
        }

    def on_device(self, types, device: str):
        """Struct of the host structures of all cases on the device."""
        host = types.HostStructure()
        host.count = len(self.modes)
        if "modes" in types.HostStructure.vars:
            modes = np.zeros(len(self.modes), dtype=types.Mode.numpy_dtype())
            for name in modes.dtype.names:
                modes[name] = [mode[name] for mode in self.modes]
            host.modes = wp.array(modes, dtype=types.Mode, device=device)
            host.signal = wp.array(self.signal or [0.0], dtype=types.real, device=device)
            host.records = wp.full(max(1, self.records), wp.vec3d(math.nan), dtype=wp.vec3d, device=device)
        return host
