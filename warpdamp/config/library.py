"""Materials of the library in a configuration: what a name stands for is written out, with its sources."""

from __future__ import annotations

from ..scene.materials import ELASTIC, LIBRARY, SURFACE, LibraryMaterial
from .messages import suggestion

COMMAND = "`warpdamp materials` lists them"


def written_out(values: dict) -> dict:
    """Values of a configuration with the materials and surfaces that it takes from the library filled in.

    A material that ``materials`` does not define is the library's of that name; one that says ``library: NAME`` takes
    from there what it does not say itself.  Restitution and friction of the library are those of a material on itself:
    they stand for what ``contact`` leaves out where all particles are of one material.

    Raises
    ------
    ValueError
        That begins with the key at fault, if the library has no such material, or not all that is needed of it.
    """
    materials = {} if values.get("materials") is None else values["materials"]
    if not isinstance(materials, dict):
        return values
    materials, named = dict(materials), _named(values)
    for where, name in named.items():
        if name in LIBRARY and name not in materials:
            _refuse_gaps(LIBRARY[name], where, name)
            materials[name] = {"library": name}
    for name, given in materials.items():
        if isinstance(given, dict) and given.get("library") is not None:
            materials[name] = _filled(name, given)
    result = {**values, "materials": materials} if materials else values
    grains = {name for where, name in named.items() if "particles" in where}
    if len(grains) == 1:
        result = _with_surface(result, materials.get(next(iter(grains))))
    return result


def _named(values: dict) -> dict[str, str]:
    """Names of materials by the keys that name them."""
    found = {}

    def look(node, path):
        if isinstance(node, dict):
            for key, below in node.items():
                if key == "material" and isinstance(below, str):
                    found[".".join((*path, key))] = below
                else:
                    look(below, (*path, str(key)))
        elif isinstance(node, list):
            for k, below in enumerate(node):
                look(below, (*path, str(k)))

    for section in ("damper", "dampers", "structure"):
        look(values.get(section), (section,))
    return found


def _refuse_gaps(material: LibraryMaterial, where: str, name: str) -> None:
    gaps = [key for key in ELASTIC if getattr(material, key) is None]
    if gaps:
        remedy = ", ".join(f"{key}: ..." for key in gaps)
        raise ValueError(
            f"{where}: the library has no {' and no '.join(gaps)} of {name} with a source: write under materials "
            f"{name}: {{library: {name}, {remedy}}}"
        )


def _filled(name: str, given: dict) -> dict:
    """A material with what it takes from the library, and the sources of that."""
    which = given["library"]
    if not isinstance(which, str) or which not in LIBRARY:
        raise ValueError(f"materials.{name}.library: there is no '{which}'{suggestion(which, LIBRARY)}; {COMMAND}")
    material = LIBRARY[which]
    taken = {key: getattr(material, key) for key in ELASTIC if given.get(key) is None and getattr(material, key)}
    if not taken:
        return given
    said = "; ".join(f"{key}: {value.cited}" for key, value in taken.items())
    return {**given, **{key: value.value for key, value in taken.items()}, "source": given.get("source") or said}


def _with_surface(values: dict, material) -> dict:
    """Values with the library's restitution and friction of the particles where ``contact`` leaves them out."""
    which = material.get("library") if isinstance(material, dict) else None
    contact = {} if values.get("contact") is None else values["contact"]
    if which not in LIBRARY or not isinstance(contact, dict):
        return values
    missing = [key for key in SURFACE if contact.get(key) is None]
    gaps = [key for key in missing if getattr(LIBRARY[which], key) is None]
    if gaps:
        raise ValueError(
            f"contact: the library has no {' and no '.join(gaps)} of {which} with a source: give {', '.join(gaps)}"
        )
    if not missing:
        return values
    taken = {key: getattr(LIBRARY[which], key) for key in missing}
    said = "; ".join(f"{key}: {value.cited}" for key, value in taken.items())
    filled = {key: value.value for key, value in taken.items()}
    return {**values, "contact": {**contact, **filled, "source": contact.get("source") or said}}
