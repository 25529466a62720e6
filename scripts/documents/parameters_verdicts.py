"""Verdicts of the paper's statements, and what they are drawn from: cells of its Table 1 and curves over Gamma."""

from __future__ import annotations

import numpy as np
from parameters_data import FAST, SLOW, effects

HOLDS, IN_PART, NOT, OPEN, UNDECIDED = "holds", "holds in part", "does not hold", "not run", "undecided"
FLUIDISED, COLLIDED = 1.7, 6.0
"""Gammas near the optima of fluidisation at 280 Hz and of collision at 39.5 Hz, in the paper's damper."""

NAMES = {
    "gamma_fluidisation": "Γ_f", "effectiveness_fluidisation": "ε_f",
    "gamma_collision": "Γ_c", "effectiveness_collision": "ε_c",
}  # fmt: skip


def percent(value: float, low: float, high: float) -> str:
    """A relative change with its interval."""
    return f"{100 * value:+.1f} % ({100 * low:+.1f} to {100 * high:+.1f})"


def cell(study: str, key: str, response: str):
    """One response of a study at the frequency where its optimum stands alone; None if it was not run."""
    found = effects(study, key)
    return None if found is None else found.sel(response=response, frequency=FAST if "fluid" in response else SLOW)


def said(study: str, key: str, response: str) -> tuple[str, str]:
    """Verdict of a cell, and its number over the whole range."""
    at = cell(study, key, response)
    if at is None:
        return "", ""
    verdict = str(at["verdict"].item())
    if not np.isfinite(at["change"]):
        return verdict, f"{NAMES[response]} {verdict}"
    ends = (float(at[f"change{end}"]) for end in ("", "_low", "_high"))
    return verdict, f"{NAMES[response]} {verdict}, {percent(*ends)} over the range"


def every(study: str, key: str, *wanted: tuple[str, str]) -> tuple[str, str]:
    """Whether all, some or none of several cells are as a statement has them."""
    found = [(said(study, key, response), verdict) for response, verdict in wanted]
    if not all(verdict for (verdict, _), _ in found):
        return OPEN, ""
    right = [verdict == expected for (verdict, _), expected in found]
    unknown = all(one or verdict == "undecided" for one, ((verdict, _), _) in zip(right, found, strict=True))
    state = HOLDS if all(right) else UNDECIDED if unknown else IN_PART if any(right) else NOT
    return state, "; ".join(words for (_, words), _ in found)


def curves(study: str, key: str, where) -> list[tuple[float, float, float, float, float]]:
    """Effects on the curve at amplitudes that ``where(frequency, gamma)`` takes: (f, Gamma, effect, low, high)."""
    found = effects(study, key)
    rows = []
    for f in found["frequency"].values:
        for gamma in found["gamma"].values:
            ends = [float(found[f"curve_effect{e}"].sel(frequency=f, gamma=gamma)) for e in ("", "_low", "_high")]
            if where(f, gamma) and np.isfinite(ends).all():
                rows.append((float(f), float(gamma), *ends))
    return rows
