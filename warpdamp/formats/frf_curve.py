"""A measured FRF as accelerance over frequency, however its file gives it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ModalError
from .frf_units import DERIVATIVES, Ordinate

LARGEST = 1e100
"""Of frequencies and values: powers of larger ones overflow."""


@dataclass(frozen=True)
class Curve:
    """Accelerance [m s^-2 N^-1] of one pair of degrees of freedom at frequencies [Hz].

    Parameters
    ----------
    frequency : (n,) increasing array, above 0
    accelerance : (n,) complex array
    name : response and reference where the file names them, as "2z/1z"
    said : how the file was read, in a sentence
    """

    frequency: np.ndarray
    accelerance: np.ndarray
    name: str = ""
    said: str = ""

    @classmethod
    def of(cls, frequency, values, kind: Ordinate, place: Callable[[int], str]) -> Curve:
        """Curve from values of any kind, sorted by frequency; a value at 0 Hz is left out and reported.

        Parameters
        ----------
        frequency : (n,) array [Hz]
        values : (n,) complex array in SI
        kind : of the values
        place : of the k-th value in the file, for messages

        Raises
        ------
        ModalError
            If a frequency is negative or given twice, or a number is too large to be squared.
        """
        frequency, values = np.asarray(frequency, float), np.asarray(values, complex)
        for wrong, what in (
            (~(np.abs(frequency) < LARGEST), "is no frequency"),
            (frequency < 0, "is negative: leave such lines out: those above 0 Hz are a two-sided FRF as it is"),
        ):
            if wrong.any():
                k = int(np.argmax(wrong))
                raise ModalError(f"{place(k)}: a frequency of {frequency[k]:g} Hz {what}")
        order = np.argsort(frequency, kind="stable")
        twice = np.flatnonzero(np.diff(frequency[order]) == 0)
        if len(twice):
            first, second = order[twice[0]], order[twice[0] + 1]
            raise ModalError(f"{place(second)}: {frequency[second]:g} Hz was given before, at {place(first)}: keep one")
        above = order[frequency[order] > 0]
        if not len(above):
            raise ModalError(f"{place(0)}: there is no value above 0 Hz")
        frequency = frequency[above]
        with np.errstate(invalid="ignore", over="ignore"):  # refused below
            values = values[above] * (2j * np.pi * frequency) ** DERIVATIVES[kind]
        if not (np.abs(values) < LARGEST).all():
            k = int(np.argmin(np.abs(values) < LARGEST))
            raise ModalError(f"{place(above[k])}: the value at {frequency[k]:g} Hz is too large or no number")
        return cls(frequency, values, said="the line at 0 Hz is left out" if len(above) < len(order) else "")

    def described(self, *said: str, name: str = "") -> Curve:
        """Curve with a name, and a description of how it was read."""
        return replace(self, name=name, said="; ".join(part for part in (*said, self.said) if part))
