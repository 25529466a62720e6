"""Frequency-dependent bushes of Nastran, read as far as tests need them."""

import numpy as np

from warpdamp.formats.nastran_bulk import cards, real


def read_bush(file):
    """Stiffness [N/m] and force per velocity [N s/m] along component 1 of the PBUSHT of a file, each (x, y)."""
    found = cards(file, enumerate(file.read_text().splitlines(), 1))
    tables = {int(card.fields[0]): _table(card) for card in found if card.name == "TABLED1"}
    (bush,) = (card for card in found if card.name == "PBUSHT")
    (nominal,) = (card for card in found if card.name == "PBUSH")
    assert nominal.fields[0] == bush.fields[0]
    at = {name: bush.fields.index(name) for name in "KB"}
    assert all(real(nominal.fields[k + 1]) == 0 for k in at.values())  # the entry beside each table
    return tuple(tables[int(bush.fields[k + 1])] for k in at.values())


def _table(card):
    pairs = [real(text) for text in card.fields[8 : card.fields.index("ENDT")]]
    return np.array(pairs[::2]), np.array(pairs[1::2])
