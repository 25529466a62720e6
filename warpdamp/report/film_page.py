"""Film as a page: a player and a view that turns, with everything in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .film import QUANTITIES, Film, turned
from .offline import as_json, packed, page, write_page

MOST_BYTES = 6_000_000
SCRIPTS = ("chart.js", "player.js")
COLOURMAP, COLOURS = "viridis", 64


def write_film_page(film: Film, path: Path) -> None:
    """Write a film as one HTML file that opens offline.

    Raises
    ------
    UsageError
        If it would be larger than ``MOST_BYTES``.
    MissingLibrary
        If Jinja2 is not installed.
    """
    data = films_data(film)
    text = page("film.html", SCRIPTS, "film", film=data[0], films=data, data=as_json(data))
    write_page(text, path, MOST_BYTES)


def films_data(film: Film) -> list[dict]:
    """What the player shows of a film and of those beside it, with colours and forces in one scale."""
    return [film_data(one, film) | {"damper": k} for k, one in enumerate(film.every, 1)]


def film_data(film: Film, scale: Film) -> dict:
    """What the player shows, as it stands in a page; see ``page/player.js``.

    Parameters
    ----------
    film : Film
    scale : Film
        Whose colours and forces are the scale.
    """
    trajectory, drive, cavity = film.trajectory, film.trajectory.scene.drive, film.trajectory.scene.enclosure
    position = np.array([frame.state.position for frame in film.frames])
    low, high = position.min(axis=(0, 1)), position.max(axis=(0, 1))
    high = np.where(high > low, high, low + 1e-9)
    radius = film.frames[0].state.radius
    bodies = turned(film.frames[0])
    arrays = {"position": ("u2", np.round(65535 * (position - low) / (high - low)))}
    for colour in QUANTITIES:
        arrays[colour.value] = ("u1", np.round(255 * np.clip(film.values(colour) / scale.most(colour), 0, 1)))
    arrays |= _contacts(film, scale.strongest)
    if bodies:
        arrays["axis"] = ("i1", np.round(127 * np.array([frame.state.axis for frame in film.frames])))
    counts = [len(frame.touching.pairs) for frame in film.frames]
    walls = {name: getattr(cavity, name) for name in ("side", "floor", "lid")}
    return {
        "title": film.title,
        "label": film.label,
        "remark": film.remark,
        "source": film.source,
        "alt": f"{film.particles} particles in their shaken cavity, {film.label}",
        "particles": film.particles,
        "frames": len(film.frames),
        "shown": film.shown,
        "cavity": {"radius": cavity.diameter / 2, "height": cavity.height, **walls},
        "drive": {"frequency": drive.frequency, "displacement": 1e3 * drive.displacement},
        "displacement": trajectory.displacement,
        "sway": np.abs(trajectory.displacement).max(axis=0),
        "cycle": [frame.cycle for frame in film.frames],
        "effectiveness": trajectory.effectiveness,
        "discarded": film.discarded,
        "radius": _once(radius),
        "along": _once(bodies.along) if bodies else None,
        "across": _once(bodies.across) if bodies else None,
        "low": low,
        "high": high,
        "contacts": np.concatenate([[0], np.cumsum(counts)]),
        "strongest": scale.strongest,
        "quantities": {
            colour.value: {"name": quantity.name, "unit": quantity.unit, "most": scale.most(colour)}
            for colour, quantity in QUANTITIES.items()
        },
        "colour": film.colour.value,
        "forces": film.forces,
        "colours": _colours(),
        "packed": packed(arrays),
    }


def _once(lengths: np.ndarray) -> np.ndarray:
    """Lengths of the particles; one where all are alike."""
    return np.unique(lengths) if np.ptp(lengths) == 0 else lengths


def _contacts(film: Film, strongest: float) -> dict:
    """Contacts of all frames one after the other; side, floor and lid are the particles n, n + 1 and n + 2."""
    n = film.particles
    pairs = np.concatenate([frame.touching.pairs for frame in film.frames]).reshape(-1, 2)
    size = np.concatenate([np.linalg.norm(frame.touching.force, axis=1) for frame in film.frames])
    kind = "u2" if n + 3 < 65536 else "u4"
    second = np.where(pairs[:, 1] < 0, n - 1 - pairs[:, 1], pairs[:, 1])
    force = np.round(255 * np.sqrt(size / strongest))
    return {"first": (kind, pairs[:, 0]), "second": (kind, second), "force": ("u1", force)}


def _colours() -> np.ndarray:
    from matplotlib import colormaps

    return np.round(255 * colormaps[COLOURMAP](np.linspace(0, 1, COLOURS))[:, :3]).astype(int)
