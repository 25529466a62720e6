"""The paper's section 4.1, from the spheroids of docs/sphericity.nc, with the statistics of docs/sphericity.md."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr
from parameters_data import results
from shape_statistics import bands, clearances, collisions, shared_part, trend
from shared import DOCS
from sphericity import BANDS, SIGNIFICANT, drifting

ENOUGH = 2.0
"""Standard errors above spheres from which on a shape is counted as above them, as in docs/sphericity.md."""


@cache
def shapes() -> tuple[xr.Dataset, xr.Dataset]:
    """Results of all shapes that were run, and their optima."""
    whole = xr.load_dataset(DOCS / "sphericity.nc")
    runs = whole.isel(aspect=whole["effectiveness"].notnull().any(["mode", "gamma", "seed"]).values)
    for name in ("natural_frequency", "mode_amplitude", "particle_mass"):  # of one mass, so of all shapes
        runs[name] = runs[name].mean([dim for dim in runs[name].dims if dim != "mode"])
    return runs, runs.damper.optimum()


def known() -> bool:
    """Whether there are packings enough to say something."""
    return results("sphericity") is not None


def higher() -> str:
    """Shapes whose optimum of collision lies above that of spheres, and the trend."""
    runs, found = shapes()
    own = collisions(runs, found)
    sphere = own[1.0]
    others = [shape for shape in own.values() if shape is not sphere]
    above = sum(rise > ENOUGH * error for rise, error in (shape.rise(sphere) for shape in others))
    at = found.sel(mode=1)
    slope = trend(runs["aspect"].values, at["gamma_collision"], at["gamma_collision_standard_error"])
    return (
        f"{above} of {len(others)} shapes lie more than two standard errors above spheres; slope of Γ_c over "
        f"\\|ln aspect\\| {slope}"
    )


def denser() -> tuple[bool, str]:
    """Whether all shapes leave more clearance than spheres, and what part of the rise that explains."""
    runs, found = shapes()
    ball, error = clearances(runs, 1.0)
    rest = {a: clearances(runs, a) for a in runs["aspect"].values.tolist() if a != 1}
    more = sum(h - ball > ENOUGH * np.hypot(error, own) for h, own in rest.values())
    share, spread = shared_part(collisions(runs, found))
    heights = ", ".join(f"{a:g}: {1e3 * h:.2f}" for a, (h, _) in rest.items())
    words = (
        f"clearance {1e3 * ball:.2f} mm with spheres, {heights} mm with aspect; {more} of {len(rest)} above spheres; "
        f"it explains {100 * share:.0f} ± {100 * spread:.0f} % of the rises of Γ_c"
    )
    return more == len(rest) and share > ENOUGH * spread, words


def beyond() -> tuple[int, int, str]:
    """Shapes whose rise is more than the clearance explains, how many there are, and the figures."""
    runs, found = shapes()
    own = collisions(runs, found)
    sphere = own[1.0]
    left = {a: shape.left(sphere) for a, shape in own.items() if shape is not sphere}
    count = sum(value > ENOUGH * error for value, error in left.values())
    words = ", ".join(f"{a:g}: {value:+.2f} ± {error:.2f}" for a, (value, error) in left.items())
    return count, len(left), f"left of the rise of Γ_c beyond the clearance's part, by aspect: {words}"


def fluidised() -> tuple[int, str]:
    """Modes in which the effectiveness below collision differs by shape, and the figures."""
    runs, _ = shapes()
    moving, words, unlike = drifting(runs), [], 0
    for band in bands(runs, BANDS):
        largest = 100 * max(map(abs, band.differences.values()))
        unlike += band.p < SIGNIFICANT
        words.append(
            f"mode {band.mode}: up to {largest:.0f} % from spheres, p {band.p:.2g}, "
            f"{100 * moving[band.mode]:.0f} % of the cases still drifting"
        )
    return unlike, "means below collision: " + "; ".join(words)
