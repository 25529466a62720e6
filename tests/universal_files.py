"""Universal files as other programs write them, record by record, for tests of the reader."""

import numpy as np

SI = (1, 1.0, 1.0)


def integers(*values):
    return "".join(f"{value:10d}" for value in values)


def reals(*values, digits=5):
    width = digits + 8 if digits == 5 else digits + 9
    per_line = 6 if digits == 5 else 3
    fields = [f"{value:{width}.{digits}e}" for value in values]
    return ["".join(fields[k : k + per_line]) for k in range(0, len(fields), per_line)]


def dataset(number, *lines):
    flat = [line for part in lines for line in ([part] if isinstance(part, str) else part)]
    return ["    -1", f"{number:6d}", *flat, "    -1"]


def units(code=1, length=1.0, force=1.0):
    factors = [f"{x:25.17e}".replace("e", "D") for x in (length, force, 1.0, 273.15)]
    return dataset(164, f"{code:10d}{'of the file':>20}{2:10d}", "".join(factors[:3]), factors[3])


def nodes_15(points, definition=0, displacement=None):
    """Nodes 1, 2, ... at points in a definition system."""
    displacement = definition if displacement is None else displacement
    rows = [integers(n, definition, displacement, 1) + reals(*point)[0] for n, point in enumerate(points, 1)]
    return dataset(15, *rows)


def nodes_2411(points, export=0, displacement=0):
    rows = [[integers(n, export, displacement, 11), *reals(*p, digits=16)] for n, p in enumerate(points, 1)]
    return dataset(2411, *rows)


def systems_18(number, kind, origin, on_x, on_xz, reference=0, method=1):
    return dataset(18, integers(number, kind, reference, 8, method), "local", reals(*origin, *on_x, *on_xz))


def systems_2420(*systems):
    """Systems (number, kind, axes as rows, origin)."""
    rows = [
        [integers(number, kind, 8), "local", *(reals(*row, digits=16)[0] for row in (*axes, origin))]
        for number, kind, axes, origin in systems
    ]
    return dataset(2420, integers(1), "part", *rows)


def _data(shape, storage):
    rows = []
    for node, values in shape.items():
        if storage in (5, 6):
            values = np.column_stack([np.real(values), np.imag(values)]).ravel()
        rows += [integers(node), *reals(*values)]
    return rows


def mode_55(
    number, shape, *, frequency=40.0, mass=2.0, viscous=0.001, hysteretic=0.0, analysis=2, characteristic=2, content=8,
    storage=2, values=3, eigenvalue=None, modal_a=0j,
):  # fmt: skip
    """A dataset 55; ``shape`` is {node: values}."""
    own = (
        [frequency, mass, viscous, hysteretic]
        if eigenvalue is None
        else [eigenvalue.real, eigenvalue.imag, modal_a.real, modal_a.imag, 0.0, 0.0]
    )
    head = [
        integers(1, analysis, characteristic, content, storage, values),
        integers(2, len(own), 1, number),
        reals(*own),
    ]
    return dataset(55, *["NONE"] * 5, *head, _data(shape, storage))


def mode_2414(
    number, shape, *, frequency=40.0, mass=2.0, viscous=0.001, hysteretic=0.0, analysis=2, characteristic=2, content=8,
    storage=2, values=3, location=1, squared=0.0, eigenvalue=0j, modal_a=0j,
):  # fmt: skip
    """A dataset 2414; ``shape`` is {node: values}, ``squared`` the real eigenvalue."""
    head = [integers(number), "MODE", integers(location), *["NONE"] * 5]
    head += [integers(1, analysis, characteristic, content, storage, values), integers(0, 0, 1, 0, 0, number, 0, 0)]
    head += [integers(0, 0), reals(0, frequency, squared, mass, viscous, hysteretic)]
    head += [reals(eigenvalue.real, eigenvalue.imag, modal_a.real, modal_a.imag, 0, 0)]
    return dataset(2414, *head, _data(shape, storage))


def binary_58b(payload=b"\n    -1\n    55\n"):
    """A dataset 58b, whose bytes look like a dataset."""
    text = "\n".join(["NONE"] * 11)
    return (
        f"    -1\n    58b     1     2          11{len(payload):12d}     0     0           0           0\n{text}\n".encode()
        + payload
        + b"    -1\n"
    )


def write(path, *sets):
    path.write_text("\n".join(line for part in sets for line in part) + "\n")
    return path
