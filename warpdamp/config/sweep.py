"""Models of the configuration: ranges, and which scalars a sweep varies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    TypeAdapter,
    model_validator,
)

Scalar = StrictBool | StrictInt | StrictFloat | StrictStr
Quantity = StrictInt | StrictFloat | StrictStr


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True, defer_build=True)


class Range(_Model):
    """Range of ``n`` values, evenly spaced (``from``, ``to``) or in equal ratios (``log``)."""

    from_: Quantity | None = Field(default=None, alias="from")
    """First value."""
    to: Quantity | None = None
    """Last value."""
    log: tuple[Quantity, Quantity] | None = None
    """First and last value of a range in equal ratios."""
    n: Annotated[StrictInt, Field(ge=2, le=1_000_000)]
    """Number of values."""

    @model_validator(mode="after")
    def _one_kind(self):
        if (self.log is None) == (self.from_ is None or self.to is None) or (
            self.log and (self.from_, self.to) != (None, None)
        ):
            raise ValueError("give {from: a, to: b, n: 5} or {log: [a, b], n: 5}")
        return self

    @property
    def ends(self) -> tuple:
        """First and last value, as written."""
        return self.log or (self.from_, self.to)

    def spread(self, read: Callable[[Any], float]) -> list:
        """Values of the range, once ``read`` has made numbers of the ends.

        Raises
        ------
        ValueError
            If the ends are no numbers, equal, or, for a logarithmic range, not positive.
        """
        import numpy as np

        first, last = map(read, self.ends)
        if self.log is not None:
            return spread(first, last, np.linspace(0, 1, self.n), logarithmic=True)
        _check_ends(first, last)
        return _alike(np.linspace(first, last, self.n), first, last)


def swept(kind, *constraints):
    """One value, or a list or range of different ones that becomes an axis."""
    scalar = Annotated[kind, *constraints]
    scalar_or_list = scalar | Annotated[list[scalar], Field(min_length=1)]

    def spread(value):
        if not isinstance(value, dict):
            return value
        return Range.model_validate(value).spread(TypeAdapter(kind).validate_python)

    return Annotated[scalar_or_list, BeforeValidator(spread, json_schema_input_type=scalar_or_list | Range)]


def as_list(value) -> list:
    """List of a swept scalar's values, whether one or a list is given."""
    return list(value) if isinstance(value, list) else [value]


def spread(first, last, part, *, logarithmic: bool) -> list:
    """Values at ``part`` (0 to 1) of the way between two ends; whole numbers where both ends are.

    Raises
    ------
    ValueError
        If the ends are no numbers, equal, or, for a logarithmic range, not positive.
    """
    _check_ends(first, last)
    if logarithmic and min(first, last) <= 0:
        raise ValueError("the ends of a logarithmic range must be positive")
    import numpy as np

    part = np.asarray(part)
    values = first * (last / first) ** part if logarithmic else first + (last - first) * part
    return _alike(np.where(part == 0, first, np.where(part == 1, last, values)), first, last)


def _check_ends(first, last) -> None:
    if any(isinstance(end, bool) or not isinstance(end, int | float) for end in (first, last)):
        raise ValueError("a range needs two numbers or quantities as its ends")
    if first == last:
        raise ValueError("the ends of a range must differ")


def _alike(values, first, last) -> list:
    """Values as whole numbers if both ends are."""
    if isinstance(first, int) and isinstance(last, int):
        return [round(v) for v in values.tolist()]
    return values.tolist()


Values = Annotated[list[Scalar], Field(min_length=1)] | Range


class Span(_Model):
    """Interval of samples, evenly distributed in the logarithm."""

    log: tuple[Quantity, Quantity]
    """Ends of the interval."""


class SampleConfig(_Model):
    """Sample of ``n`` points over the ranges of several scalars."""

    method: Literal["sobol", "latin_hypercube"] = "sobol"
    """Sobol sequence, or Latin hypercube."""
    n: Annotated[StrictInt, Field(ge=1, le=10_000_000)]
    """Number of points."""
    seed: Annotated[StrictInt, Field(ge=0)] = 0
    """Seed of the sample."""
    over: Annotated[dict[str, tuple[Quantity, Quantity] | Span], Field(min_length=1)]
    """Interval of each scalar, by its path."""


class Between(_Model):
    """Closed interval of values."""

    from_: Quantity = Field(alias="from")
    """Lower end."""
    to: Quantity
    """Upper end."""


class SweepConfig(_Model):
    """Scalars of the configuration, by their paths, that take several values.

    ``product``: every combination.  ``zip``: groups of scalars that change together.  ``sample``: random points in
    ranges.  ``csv``: a table, one scalar a column.  ``exclude``: combinations to leave out.
    """

    product: dict[str, Values] = {}
    """Values of each scalar, by its path: every combination, a dimension each."""
    zip: list[Annotated[dict[str, Values], Field(min_length=1)]] = []
    """Groups of scalars that change together, along the dimension ``case``."""
    sample: SampleConfig | None = None
    """Random points in ranges, along the dimension ``case``."""
    csv: str | None = None
    """Table beside the configuration, whose columns are paths, along the dimension ``case``."""
    exclude: list[Annotated[dict[str, Scalar | list[Scalar] | Between], Field(min_length=1)]] = []
    """Combinations to leave out: where all of an entry holds."""

    @model_validator(mode="after")
    def _something(self):
        if not (self.product or self.zip or self.sample or self.csv or self.exclude):
            raise ValueError("nothing is swept: give product, zip, sample or csv, or leave the section out")
        return self

    def keys(self) -> list[str]:
        """Paths of the scalars that it varies, as written; those of a table beside it are not among them."""
        sampled = self.sample.over if self.sample else {}
        return [*self.product, *(key for group in self.zip for key in group), *sampled]

    def varies(self, *names: str) -> bool:
        """Whether it varies a scalar whose path ends in one of some names."""
        return any(key.rpartition(".")[2] in names for key in self.keys())
