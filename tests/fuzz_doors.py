"""Valid FRF files and configurations, damaged in every way, and what must hold of the readers: one line, no traceback.

``mutated(rng)`` makes a case and ``check(case, folder)`` tries it; a case is drawn from a random generator alone, so
that any of a long series can be made again from its number.
"""

from dataclasses import dataclass

import numpy as np

from frf_files import FREQUENCY, IN, MM, SI, accelerance, binary58, frf58, integrated, table, uff
from warpdamp import ConfigError, load
from warpdamp.errors import ModalError
from warpdamp.modal.frf_file import read_frf
from warpdamp.modal.identify import fits

LINES = slice(370, 430)  # round the peak at 39.5 Hz
F, A = FREQUENCY[LINES], accelerance()[LINES]
Y = integrated(1)[LINES]
STUDY = """damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 3 300 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 86 %}
excitation: {gamma: [1, 2], frequency: [46 Hz, 0.1 kHz], gravity: 9.81 m/s^2}
seeds: [1]
"""
VALID = {
    "real.csv": table((F, A.real, A.imag), "f [Hz],Re [(m/s^2)/N],Im [(m/s^2)/N]"),
    "polar.csv": table((F, abs(Y), np.degrees(np.angle(Y))), "Frequency;|Y| [mm/s/N];Phase [deg]", mark=";", decimal=","),
    "decibel.txt": table((F, 20 * np.log10(abs(A)), np.angle(A)), "omega [rad/s]\tmag [dB re 1 g/N]\tphase [rad]", mark="\t"),
    "wide.csv": table((F, A.real, A.imag), "Frequenz [Hz],Re,Im", encoding="utf-16"),
    "text.uff": uff(SI, frf58(A, F), frf58(Y, F, numerator=(11, "m/s"), response=(3, 1))),
    "uneven.unv": uff(MM, frf58(A, F, numerator=(12, ""), denominator=(13, ""), data_type=6, even=False)),
    "binary.uf": uff(IN) + binary58(A, F, numerator=(12, ""), denominator=(13, "")),
    "study.yaml": STUDY.encode(),
}  # fmt: skip
PIECES = (
    "", " ", ",", ";", "\t", "\n", "\r\n", "\0", "\ufeff", "é", "\u00a0", "-", "-1", "    -1\n", "0", "1e400", "nan", "inf", "1e", "D+00",
    "9" * 30, "9" * 400, "1 1/4", "7 800", "0,52", "in", "mm", "kg", "N", "dB", "rad/s", "(m/s", "^99", "/0", "%", "#", "[", "{", "'", '"', ":",
    "- ", "&a", "*a", "!!", "Re", "Phase", "    58b     1     2          11        9999", "    58", "   164", "*" * 200, "(" * 200,
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A file that was valid, and the options that it is read with."""

    name: str
    content: bytes
    options: dict


def mutated(rng: np.random.Generator) -> Case:
    """A valid file with one to four damages, and options that mostly fit it."""
    name = str(rng.choice(list(VALID)))
    content = VALID[name]
    for _ in range(int(rng.choice([1, 1, 2, 4]))):
        content = _damaged(content, rng)
    options = {}
    if name.endswith(("uff", "unv", "uf")):
        options = (
            {"response": None, "number": 1, "every": False} if rng.random() < 0.7 else {"response": "2z", "every": True}
        )
    if rng.random() < 0.1:
        options |= {"ordinate": str(rng.choice(["accelerance", "mobility", "receptance"]))}
    if rng.random() < 0.1:
        options |= {"units": str(rng.choice(["g/N", "mm/s/N", "m/N", "kg", *PIECES]))}
    return Case(name, content, {} if name.endswith("yaml") else options)


def check(case: Case, folder) -> bool:
    """Whether a case is accepted; an error that is none of the package's, or of more than a line, comes through."""
    path = folder / case.name
    path.write_bytes(case.content)
    try:
        if path.suffix == ".yaml":
            load(path)
        else:
            _plausible(fits(read_frf(path, **case.options)))
    except (ConfigError, ModalError) as error:
        _one_line_each(error, path)
        return False
    return True


def _one_line_each(error: Exception, path) -> None:
    """A configuration may have several errors, each on a line with its place."""
    lines = str(error).splitlines()
    assert lines, error
    if isinstance(error, ConfigError):
        assert all(line.startswith(str(path)) for line in lines), error
    else:
        assert len(lines) == 1, error


def _plausible(found) -> None:
    kept = found["fitted_frequency"].notnull()
    inside = (found["fitted_frequency"] >= found["band_start"]) & (found["fitted_frequency"] <= found["band_end"])
    assert (inside | ~kept).all()
    assert ((found["fitted_damping_ratio"] > 0) | ~kept).all()


def _damaged(content: bytes, rng) -> bytes:
    """One damage: bytes changed or left out, the end cut, a piece put in, lines replaced, exchanged, doubled, a digit."""
    if not content:
        return b"1"
    at = int(rng.integers(len(content)))
    length = int(rng.choice([1, 2, 13, 80]))
    lines = content.split(b"\n")
    j, k = (int(n) for n in rng.integers(len(lines), size=2))
    piece = str(rng.choice(PIECES)).encode("utf-8" if rng.random() < 0.7 else "utf-16")
    digits = [
        place for place in range(max(0, at - 200), min(len(content), at + 200)) if content[place : place + 1].isdigit()
    ]
    match int(rng.integers(11)):
        case 0:
            return content[:at] + rng.bytes(length) + content[at + length :]
        case 1:
            return content[:at] + content[at + length :]
        case 2:
            return content[:at]
        case 3:
            return content[:at] + piece + content[at:]
        case 4:
            lines[j] = piece
        case 5:
            lines[j], lines[k] = lines[k], lines[j]
        case 6:
            lines[j:j] = [lines[k]]
        case 7 | 8 | 9 if digits:
            place = int(rng.choice(digits))
            return content[:place] + b"%d" % rng.integers(10) + content[place + 1 :]
        case _:
            fields = lines[j].split(b" ")
            fields[int(rng.integers(len(fields)))] = piece
            lines[j] = b" ".join(fields)
    return b"\n".join(lines)
