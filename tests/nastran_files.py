"""A lumped model, its exact modes, and the .bdf, .f06 and .pch in which Nastran would give them."""

import numpy as np

POINTS = {11: (0.0, 0.0, 0.0), 12: (300.0, 0.0, 0.0), 20: (600.0, 0.0, 0.0)}
MASS = np.diag([0.001, 0.002, 0.0015])
STIFFNESS = 80.0 * np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])


def exact(mass=MASS):
    """Eigenvalues and mass-normalised shapes along z: three masses in tonnes on springs in N/mm."""
    from scipy.linalg import eigh

    return eigh(STIFFNESS, mass)


def grid(system="", definition="", points=POINTS):
    return [f"GRID    {n:8d}{definition!s:>8}{x:8.2f}{y:8.2f}{z:8.2f}{system!s:>8}" for n, (x, y, z) in points.items()]


def lumped(mass=MASS):
    return [
        f"CONM2   {k:8d}{n:8d}{'':8}{m:8.5f}" for k, (n, m) in enumerate(zip(POINTS, np.diag(mass), strict=True), 1)
    ]


def dmig(mass, name="MAAX"):
    """The matrix of the points' z, its lower triangle, in large fields."""
    lines, nodes = [f"DMIG    {name:8}       0       6       1       0"], [*POINTS]
    for j, column in enumerate(nodes):
        lines.append(f"DMIG*   {name:16}{column:16d}{3:16d}{'':16}")
        lines += [
            f"*       {nodes[i]:16d}{3:16d}{mass[i, j]:16.9E}".replace("E", "D")
            for i in range(j, len(nodes))
            if mass[i, j]
        ]
    return lines


def f06(shapes, eigenvalues, masses, *, echo=(), kind="G"):
    """``shapes`` are (n, 6) at the points, mode by mode; a page break in the middle of each."""
    lines = ["1    SUBCASE 1", "0", " " * 49 + "S O R T E D   B U L K   D A T A   E C H O"] if echo else []
    lines += [f"{k:19d}-        {card}" for k, card in enumerate(echo, 1)]
    lines += [
        "1",
        " " * 46 + "R E A L   E I G E N V A L U E S",
        "   MODE    EXTRACTION      EIGENVALUE ",
        "    NO.       ORDER",
    ]
    for k, (value, mass) in enumerate(zip(eigenvalues, masses, strict=True), 1):
        w = np.sqrt(abs(value))
        lines.append(f"{k:9d}{k:10d}" + "".join(f"{x:20.6E}" for x in (value, w, w / 2 / np.pi, mass, value * mass)))
    for k, (value, shape) in enumerate(zip(eigenvalues, shapes, strict=True), 1):
        for node, row in zip(POINTS, shape, strict=True):
            if node in (11, 20):
                lines += ["1", f"      EIGENVALUE =  {value:.6E}"]
                lines.append(f"          CYCLES =  1.0         R E A L   E I G E N V E C T O R   N O .  {k:9d}")
                lines.append(
                    "      POINT ID.   TYPE          T1             T2             T3             R1             R2             R3"
                )
            lines.append(f"{node:14d}      {kind}   " + "".join(f"{x:15.6E}" for x in row))
    return "\n".join([*lines, "1", "                    * * * END OF JOB * * *"]) + "\n"


def pch(shapes, eigenvalues, *, extra=(), output="REAL OUTPUT"):
    lines = []
    for k, (value, shape) in enumerate(zip(eigenvalues, shapes, strict=True), 1):
        lines += [
            "$TITLE   = three masses",
            "$SUBTITLE=",
            "$LABEL   =",
            "$EIGENVECTOR",
            f"${output}",
            "$SUBCASE ID =           1",
        ]
        lines.append(f"$EIGENVALUE =  {value:.7E}  MODE = {k:5d}")
        for node, row in zip(POINTS, shape, strict=True):
            lines.append(f"{node:10d}       G" + "".join(f"{x:18.6E}" for x in row[:3]))
            lines.append(f"-CONT-{'':12}" + "".join(f"{x:18.6E}" for x in row[3:]))
    return "\n".join(f"{line:72}{k:8d}" for k, line in enumerate([*lines, *extra], 1)) + "\n"
