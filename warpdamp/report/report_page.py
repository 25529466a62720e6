"""Report of a study as one page that opens offline."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .content import content, cost, optima_table, question_and_answers
from .film import Film
from .film_page import films_data
from .offline import as_json, page, write_page
from .tables import verdicts

if TYPE_CHECKING:
    import xarray as xr

    from ..modes import Modes

MOST_BYTES = 8_000_000
SCRIPTS = ("chart.js", "player.js", "report.js")


def write_report(
    dataset: xr.Dataset,
    path: Path,
    *,
    modes: Modes | str = "",
    film: Film | str = "",
) -> None:
    """Write the report of a study as one HTML file, which loads nothing from anywhere.

    Parameters
    ----------
    dataset : xarray.Dataset
        Results.
    path : Path
    modes : Modes or str
        Of the structure with the particles; or why none are drawn.
    film : Film or str
        Of one case; or why there is none.

    Raises
    ------
    UsageError
        If no case is finished, or the page would be larger than ``MOST_BYTES``.
    MissingLibrary
        If Jinja2 is not installed.
    """
    shown = content(dataset, None if isinstance(modes, str) else modes)
    shown["film"] = None if isinstance(film, str) else films_data(film)
    if not shown["modes"] and not isinstance(modes, str):
        modes = "The modes are known at the damper only: they have no shape to draw."
    question, answers = question_and_answers(dataset)
    own_interval = "energy_mean_interval" in dataset
    text = page(
        "report.html",
        SCRIPTS,
        "report",
        title=shown["title"],
        question=question,
        answers=answers,
        interval="95 % intervals" if own_interval else "1.96 standard errors (these results hold no intervals)",
        preparation=_preparation(dataset),
        optima=optima_table(dataset),
        losses=shown["losses"],
        regimes=bool(shown["regimes"]),
        bed=bool(shown["bed"]),
        map=_has_map(shown["dims"]),
        no_modes=modes if isinstance(modes, str) else "",
        no_film=film if isinstance(film, str) else "",
        film_label="" if isinstance(film, str) else "; ".join(one.label for one in film.every),
        no_calculator=shown["calculator"].get("why_not", ""),
        verdicts=verdicts(dataset),
        cost=cost(dataset),
        yaml=dataset.attrs.get("configuration", ""),
        versions=versions_of(dataset),
        effects=str(dataset.attrs.get("effects", "")),
        data=as_json(shown),
    )
    write_page(text, path, MOST_BYTES)


def versions_of(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """What made results, as named values."""
    return [(name, str(dataset.attrs[name])) for name in ("source", "history", "references") if name in dataset.attrs]


def _preparation(dataset: xr.Dataset) -> str:
    one = "preparation" in dataset.coords and dataset["preparation"].ndim == 0
    return f"{dataset['preparation'].item()} beds" if one else ""


def _has_map(dims: dict[str, int]) -> bool:
    """Whether two of the dimensions are long enough for a map."""
    return sum(size >= FEWEST_OF_A_MAP for size in dims.values()) >= 2


FEWEST_OF_A_MAP = 3
