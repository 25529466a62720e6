"""What a tolerance saves: the main job at 5 % against the paper's step and one fixed length; writes docs/price.nc.

    python scripts/documents/price.py [--workers N]

The main job on every eighth of its amplitudes, both ways in one run, from the same beds.  The fixed length is the
shortest with which every case would have the standard error that the tolerance gives it: the longest that any steady
case took.  About four minutes on two cores.
"""

from __future__ import annotations

import argparse

import numpy as np
import xarray as xr
from shared import DOCS, ROOT, processes

from warpdamp import load, run
from warpdamp.analysis.results import write
from warpdamp.config.study import Config
from warpdamp.damper.case import Criteria
from warpdamp.damper.shake import shake
from warpdamp.sweep.cases import Cases
from warpdamp.variables import NOT_RUN

TOLERANCE, PAPER_STEP = 0.05, 2e-6


def job(**changes) -> Config:
    """The main job on every eighth amplitude."""
    config = load(ROOT / "configs" / "beam.yaml")
    values = config.model_dump()
    values["excitation"]["gamma"] = config.excitation.gamma[3::8]
    for name in ("steady_state", "numerics", "seeds"):
        del values[name]
    return Config.model_validate(values | changes)


def fixed(length: int, seeds: list[int], workers: int | None) -> list[tuple[tuple[int, ...], dict]]:
    """The same cases at the paper's step, each for ``length`` cycles, with their places (frequency, gamma, seed)."""
    config = job(numerics={"step": PAPER_STEP}, seeds=seeds)
    specs = sorted(Cases(config).specs(), key=lambda spec: -spec.steps_per_cycle)
    criteria = Criteria(fewest=length, most=length, fixed=True)
    with processes(workers) as executor:
        done = executor.map(shake, [[[spec]] for spec in specs], [criteria] * len(specs))
        return [result for results in done for result in results]


def main() -> None:
    """Both ways, and what each cost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int)
    workers = parser.parse_args().workers
    bought = run(job(accuracy={"tolerance": TOLERANCE}), workers=workers)
    ran = bought["status"] != NOT_RUN
    steady = bought["status"] == 0
    length = int(bought["cycles"].where(steady).max())
    paid = fixed(length, [1, 2, 3], workers)
    first = ran & (bought["seed"] <= 3)
    energies = np.full((bought.sizes["frequency"], bought.sizes["gamma"], 3), np.nan)
    for index, value in paid:
        energies[index] = value["energy_dissipated"]
    result = xr.Dataset(
        {
            "tolerance_cpu_time": ((), float(bought["cpu_time"].where(ran).sum())),
            "tolerance_cases": ((), int(ran.sum())),
            "tolerance_cpu_time_first_packings": ((), float(bought["cpu_time"].where(first).sum())),
            "fixed_cpu_time": ((), sum(value["cpu_time"] for _, value in paid)),
            "fixed_cases": ((), len(paid)),
            "fixed_cycles": ((), length),
            "cycles": ("case", bought["cycles"].where(ran).values[ran.values].astype(float)),
            "within_tolerance": ("point", bought["within_tolerance"].transpose("frequency", "gamma").values.ravel()),
            "status": ("case", bought["status"].values[ran.values]),
            "fixed_status": ("fixed_case", np.array([value["status"] for _, value in paid])),
            "claimed": ("point", bought["energy_mean"].transpose("frequency", "gamma").values.ravel()),
            "claimed_error": (
                "point",
                bought["energy_mean_standard_error"].transpose("frequency", "gamma").values.ravel(),
            ),
            "fixed": ("point", energies.mean(axis=-1).ravel()),
        }
    )
    write(result, DOCS / "price.nc")
    print(result)


if __name__ == "__main__":
    main()
