"""Tables of the materials library."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..scene.materials import ELASTIC, LIBRARY, SOURCES, SURFACE, Value

if TYPE_CHECKING:
    from rich.table import Table

SHOWN = {
    "density": (1.0, "density [kg/m³]"),
    "youngs_modulus": (1e-9, "E [GPa]"),
    "poissons_ratio": (1.0, "ν"),
    "restitution": (1.0, "restitution"),
    "friction": (1.0, "friction"),
}


def materials_table() -> Table:
    """All materials with the values that have a source."""
    from rich.table import Table

    table = Table("material", *(title for _, title in SHOWN.values()))
    for name, material in LIBRARY.items():
        values = material.values()
        table.add_row(name, *(_number(values.get(key), factor) for key, (factor, _) in SHOWN.items()))
    return table


def material_lines(name: str) -> list[str]:
    """What the library knows of a material: value, range, sources."""
    material = LIBRARY[name]
    values = material.values()
    lines = [f"{name}: {material.title}"]
    for key in (*ELASTIC, *SURFACE):
        factor, title = SHOWN[key]
        if key not in values:
            lines.append(f"  {title}: no value with a source: give your own")
            continue
        value = values[key]
        at = f" at {value.speed:g} m/s" if value.speed is not None else ""
        span = f"{factor * value.low:.5g} to {factor * value.high:.5g}"
        lines.append(f"  {title}: {_number(value, factor)}{at} ({span}): {value.cited}")
    for other in material.beside:
        e, mu = other.restitution, other.friction
        said = f"restitution {_number(e, 1.0)} at {e.speed:g} m/s, friction {_number(mu, 1.0)}"
        lines.append(f"  on {other.against} (to be given under contact.pairs): {said}: {e.cited}")
    if "restitution" in values and values["restitution"].speed is None:
        lines.append("  restitution: of the impact speeds of its source")
    return lines


def sources_lines() -> list[str]:
    """All sources."""
    return [f"{word}: {citation}" for word, citation in SOURCES.items()]


def _number(value: Value | None, factor: float) -> str:
    return "-" if value is None else f"{factor * value.value:.5g}"
