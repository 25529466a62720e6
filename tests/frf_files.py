"""FRFs of known modes, written as tables and universal files of every form."""

import struct

import numpy as np

FREQUENCY = np.round(np.arange(20, 100, 0.05), 2)
MODES = ((39.5, 0.01, 2.5), (71.0, 0.02, 1.0))  # f [Hz], zeta, modal constant [kg^-1]
G, INCH, POUND = 9.80665, 0.0254, 4.4482216152605


def accelerance(frequency=FREQUENCY, modes=MODES, *, viscous=False):
    """Sum of modes [m s^-2 N^-1]."""
    w = 2 * np.pi * np.asarray(frequency, float)
    total = np.zeros(len(w), complex)
    for f, zeta, constant in modes:
        own = 2 * np.pi * f
        total += -(w**2) * constant / (own**2 - w**2 + 2j * zeta * own * (w if viscous else own))
    return total


def integrated(times, frequency=FREQUENCY, **options):
    """Mobility (once) or receptance (twice) in SI."""
    return accelerance(frequency, **options) / (2j * np.pi * np.asarray(frequency)) ** times


def table(columns, head="", *, mark=",", decimal=".", encoding="utf-8", end="\n"):
    """The bytes of a table."""
    rows = [mark.join(f"{x:.12g}".replace(".", decimal) for x in row) for row in zip(*columns, strict=True)]
    return end.join([*([head] if head else []), *rows, ""]).encode(encoding)


def dataset(number, *lines):
    return ["    -1", f"{number:6d}", *lines, "    -1"]


def units(code, name, length, force):
    factors = "".join(f"{x:25.17E}".replace("E", "D") for x in (length, force, 1.0))
    return dataset(164, f"{code:10d}{name:<20}{2:10d}", factors, f"{273.15:25.17E}".replace("E", "D"))


SI, MM, IN = units(1, "SI", 1.0, 1.0), units(5, "MM", 1e3, 1e3), units(7, "IN", 39.37007874, 0.2248089431)


def head58(
    count, *, kind=4, response=(2, 3), reference=(1, 3), data_type=5, even=True, first=0.0, step=0.0,
    abscissa=(18, "Hz"), numerator=(12, "m/s^2"), denominator=(13, "N"), exponents=((0, 0, 0), (0, 0, 0)), load_case=0, z=0.0,
):  # fmt: skip
    """The eleven lines of a dataset 58 above its values."""

    def axis(code, unit, powers=(0, 0, 0)):
        return f"{code:10d}" + "".join(f"{p:5d}" for p in powers) + f" {'NONE':<20} {unit or 'NONE':<20}"

    freedom = f"{kind:5d}{0:10d}{0:5d}{load_case:10d} {'NONE':<10}{response[0]:10d}{response[1]:4d} {'NONE':<10}{reference[0]:10d}{reference[1]:4d}"
    form = f"{data_type:10d}{count:10d}{int(even):10d}{first:13.5e}{step:13.5e}{z:13.5e}"
    axes = [axis(*abscissa), axis(*numerator, exponents[0]), axis(*denominator, exponents[1]), axis(0, "")]
    return [*["NONE"] * 5, freedom, form, *axes]


def frf58(values, frequency=FREQUENCY, *, data_type=5, even=True, **fields):
    """A dataset 58 as lines of text."""
    where = {"first": frequency[0], "step": frequency[1] - frequency[0]} if even else {}
    head = head58(len(frequency), data_type=data_type, even=even, **where, **fields)
    double = data_type in (4, 6)
    parts = [values.real, values.imag] if data_type in (5, 6) else [values.real]
    number = (lambda x: f"{x:20.12e}") if double else (lambda x: f"{x:13.5e}")
    rows = [
        "".join([*([f"{f:13.5e}"] if not even else []), *(number(part) for part in row)])
        for f, *row in zip(frequency, *parts, strict=True)
    ]
    group = {(5, 1): 3, (5, 0): 2, (6, 1): 2, (6, 0): 1, (2, 1): 6, (2, 0): 3, (4, 1): 4, (4, 0): 2}[
        data_type, int(even)
    ]
    lines = ["".join(rows[k : k + group]) for k in range(0, len(rows), group)]
    return dataset(58, *head, *lines)


def uff(*sets):
    """The bytes of a universal file of text."""
    return "\n".join(line for one in sets for line in [*one, ""][:-1]).encode() + b"\n"


def binary58(values, frequency=FREQUENCY, *, order="<", data_type=5, even=True, **fields):
    """The bytes of a dataset 58b."""
    where = {"first": frequency[0], "step": frequency[1] - frequency[0]} if even else {}
    head = head58(len(frequency), data_type=data_type, even=even, **where, **fields)
    columns = [*([frequency] if not even else []), values.real, values.imag]
    numbers = np.column_stack(columns).ravel()
    data = struct.pack(f"{order}{len(numbers)}{'d' if data_type == 6 else 'f'}", *numbers)
    first = f"{58:6d}b{1 if order == '<' else 2:6d}{2:6d}{11:12d}{len(data):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    return "\n".join(["    -1", first, *head, ""]).encode() + data + b"\n    -1\n"
