"""Library of particle and wall materials: every value with its range and its source.

A value is in here only if its source is, and could be looked up, in the source or where others quote it by name: what
is missing (restitution of most materials, Poisson's ratio of some) is left to the configuration.  Coating, roughness,
wear and impact speed change restitution and friction more than the material does: measure them where they matter.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

SOURCES = {
    "bass": "Bass 1995, Elasticity of minerals, glasses, and melts, table 3, doi:10.1029/RF002p0045 (from isotropic "
    "averages, K 37.8 GPa and G 44.3 GPa)",
    "callister": "Callister & Rethwisch, Materials Science and Engineering, appendix B, ISBN 978-0-470-41997-7",
    "cued": "Cambridge University Engineering Department, Materials Data Book, 2003 edition, section II",
    "en1993": "EN 1993-1-1, 3.2.6",
    "en572": "EN 572-1",
    "foerster": "Foerster, Louge, Chang & Allia 1994, Physics of Fluids 6, 1108, doi:10.1063/1.868282 (spheres on each "
    "other)",
    "heyliger": "Heyliger, Ledbetter & Kim 2003, Elastic constants of natural quartz, table II (isotropic average)",
    "kharaz": "Kharaz, Gorham & Salman 2001, Powder Technology 120, 281, doi:10.1016/S0032-5910(01)00283-2 (5 mm "
    "spheres on a thick anvil)",
    "munro": "Munro 1997 in NIST Property Data Summaries, SRD 150, sintered alumina, doi:10.18434/T42G62",
    "nist": "NIST Standard Reference Database 124, material compositions, doi:10.18434/T4NC7P",
    "sunday": "Sunday et al. 2020, MNRAS 498, 1062, table 2, arXiv:2009.10448 (1 mm beads)",
    "terzioglu": "Terzioglu & Rongong, Selection of granular damper parameters to achieve optimum vibration "
    "attenuation on vibrating structures, table 2",
}
"""Citations by the words that values name them with."""


@dataclass(frozen=True)
class Value:
    """Value in SI, its range, and where they are from.

    Parameters
    ----------
    value, low, high : float
    sources : words of ``SOURCES``; the value is of the first, the range of all
    speed : impact speed [m/s] of a restitution, where the source states one
    """

    value: float
    low: float
    high: float
    sources: tuple[str, ...]
    speed: float | None = None

    @property
    def cited(self) -> str:
        """The sources in full."""
        return "; ".join(SOURCES[word] for word in self.sources)


@dataclass(frozen=True)
class Beside:
    """Restitution and friction of a material on another one.

    Parameters
    ----------
    against : what the other one is
    restitution, friction : [-]
    """

    against: str
    restitution: Value
    friction: Value


@dataclass(frozen=True)
class LibraryMaterial:
    """Material of the library; what has no source is None.

    Parameters
    ----------
    title : what it is
    density : [kg/m^3]
    youngs_modulus : [Pa]
    poissons_ratio, restitution, friction : [-]; the last two of the material on itself
    beside : of the material on others; never taken by itself
    """

    title: str
    density: Value | None = None
    youngs_modulus: Value | None = None
    poissons_ratio: Value | None = None
    restitution: Value | None = None
    friction: Value | None = None
    beside: tuple[Beside, ...] = ()

    def values(self) -> dict[str, Value]:
        """Values that have a source, by name."""
        found = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("title", "beside")}
        return {name: value for name, value in found.items() if value is not None}


ELASTIC = ("density", "youngs_modulus", "poissons_ratio")
SURFACE = ("restitution", "friction")


def _value(text: str, unit: float = 1.0, *, speed: float | None = None) -> Value:
    """Value of ``"7850 7850-7874 callister nist"``: value, range, sources; restitution at an impact speed [m/s]."""
    number, span, *sources = text.split()
    low, _, high = span.partition("-")
    return Value(unit * float(number), unit * float(low), unit * float(high), tuple(sources), speed)


def _material(title: str, density="", modulus="", poisson="", **surface) -> LibraryMaterial:
    elastic = zip(ELASTIC, (density, modulus, poisson), (1.0, 1e9, 1.0), strict=True)
    return LibraryMaterial(title, **{name: _value(text, unit) for name, text, unit in elastic if text}, **surface)


LIBRARY = {
    "steel_structural": _material(
        "structural steel", "7850 7850-7874 callister nist", "210 200-215 en1993 cued", "0.30 0.30-0.30 en1993"
    ),
    "steel_ball_bearing": _material(
        "hardened low-alloy steel, as of ball bearings (values of 4140)",
        *("7850 7800-7900 callister cued", "207 200-215 callister cued", "0.30 0.30-0.30 callister"),
    ),
    "stainless_steel_304": _material(
        "austenitic stainless steel 304",
        *("8000 7600-8100 callister cued", "193 189-210 callister cued", "0.30 0.30-0.30 callister"),
    ),
    "stainless_steel_440": _material(
        "martensitic stainless steel 440A",
        *("7800 7600-8100 callister cued", "200 189-210 callister cued", "0.30 0.30-0.30 callister"),
    ),
    "cast_iron_grey": _material(
        "grey cast iron", "7300 7050-7300 callister cued", "101 66-138 callister", "0.26 0.26-0.26 callister"
    ),
    "tungsten_carbide": _material(
        "tungsten carbide, sintered", "15600 15300-15900 cued", "650 600-720 cued"
    ),
    "tungsten": _material(
        "tungsten", "19300 19250-19300 callister nist", "400 400-400 callister", "0.28 0.28-0.28 callister"
    ),
    "lead": _material(
        "lead",
        *("11340 11340-11350 callister nist", "13.5 12.5-15.0 callister cued", "0.44 0.44-0.44 callister"),
    ),
    "copper": _material(
        "copper",
        *("8890 8890-8960 callister nist", "115 112-148 callister cued", "0.33 0.33-0.33 callister"),
    ),
    "brass": _material(
        "brass, 70 % copper and 30 % zinc",
        *("8530 8500-8530 callister", "110 97-110 callister", "0.35 0.34-0.35 callister"),
    ),
    "zinc": _material(
        "zinc", "7130 7130-7133 callister nist", "104.5 104.5-104.5 callister", "0.25 0.25-0.25 callister"
    ),
    "aluminium_6061": _material(
        "aluminium alloy 6061",
        *("2700 2500-2900 callister cued", "69 68-82 callister cued", "0.33 0.33-0.33 callister"),
    ),
    "magnesium_az31b": _material(
        "magnesium alloy AZ31B",
        *("1770 1740-1950 callister cued", "45 42-47 callister cued", "0.35 0.35-0.35 callister"),
    ),
    "titanium_ti6al4v": _material(
        "titanium alloy Ti-6Al-4V",
        *("4430 4400-4800 callister cued", "114 90-120 callister cued", "0.34 0.34-0.34 callister"),
    ),
    "alumina": _material(
        "aluminium oxide, sintered, 99.9 %",
        *("3980 3970-3984 callister nist munro", "380 380-416 callister munro", "0.22 0.22-0.231 callister munro"),
        beside=(
            Beside(
                "soda-lime glass",
                restitution=_value("0.98 0.98-0.98 kharaz", speed=3.85),
                friction=_value("0.092 0.092-0.092 kharaz"),
            ),
        ),
    ),
    "silicon_nitride": _material(
        "silicon nitride, sintered",
        *("3300 3000-3300 callister cued", "304 280-310 callister cued", "0.28 0.28-0.30 callister"),
    ),
    "silicon_carbide": _material(
        "silicon carbide, sintered", "3200 3200-3300 callister", "345 207-483 callister", "0.16 0.16-0.17 callister"
    ),
    "zirconia": _material(
        "zirconium oxide with 3 mol% yttria",
        *("6000 6000-6000 callister", "205 205-205 callister", "0.31 0.31-0.31 callister"),
    ),
    "soda_lime_glass": _material(
        "soda-lime glass",
        *("2500 2440-2500 en572 cued", "70 68-72 en572 cued", "0.20 0.20-0.23 en572 callister"),
        restitution=_value("0.97 0.97-0.97 foerster sunday"),
        friction=_value("0.16 0.16-0.16 sunday"),
    ),
    "borosilicate_glass": _material(
        "borosilicate glass", "2230 2200-2300 callister cued", "64 61-70 cued callister", "0.20 0.20-0.20 callister"
    ),
    "quartz_sand": _material(
        "quartz, as the grains of sand",
        *("2648 2647-2648 bass heyliger", "95.6 95.6-99.5 bass heyliger", "0.08 0.06-0.08 bass heyliger"),
    ),
    "pmma": _material(
        "acrylic glass (PMMA)",
        *("1190 1160-1220 callister cued", "3.3 2.24-3.80 terzioglu cued", "0.37 0.37-0.37 terzioglu"),
    ),
    "pmma_terzioglu": _material(
        "spheres of PMMA as Terzioglu & Rongong give them",
        *("920 920-920 terzioglu", "3.3 3.3-3.3 terzioglu", "0.37 0.37-0.37 terzioglu"),
        restitution=_value("0.52 0.52-0.52 terzioglu"),
        friction=_value("0.86 0.86-0.86 terzioglu"),
    ),
    "nylon_66": _material(
        "nylon 6,6", "1140 1120-1140 callister cued", "2.9 1.59-3.79 cued callister", "0.39 0.39-0.39 callister"
    ),
    "polycarbonate": _material(
        "polycarbonate", "1200 1140-1210 callister cued", "2.38 2.00-2.44 callister cued", "0.36 0.36-0.36 callister"
    ),
    "polystyrene": _material(
        "polystyrene", "1050 1040-1060 callister nist", "2.8 2.28-3.34 callister cued", "0.33 0.33-0.33 callister"
    ),
    "ptfe": _material(
        "PTFE", "2170 2140-2200 callister cued", "0.48 0.40-0.552 callister cued", "0.46 0.46-0.46 callister"
    ),
    "pvc": _material(
        "PVC", "1440 1300-1580 callister cued", "3.2 2.14-4.14 callister cued", "0.38 0.38-0.38 callister"
    ),
    "polypropylene": _material("polypropylene", "905 890-910 callister cued", "1.2 0.896-1.55 cued"),
    "polyoxymethylene": _material("polyoxymethylene (acetal)", "1410 1390-1430 cued", "3.5 2.5-5.0 cued"),
    "natural_rubber": _material("natural rubber", "925 920-930 cued", "0.002 0.0015-0.0025 cued"),
}  # fmt: skip
"""Materials by name."""
