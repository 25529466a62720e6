"""Modes from UFF and CSV files: what is written comes back, and what cannot be scaled is refused."""

import numpy as np
import pytest

from warpdamp.errors import ModalError
from warpdamp.formats.mode_csv import read_csv, write_csv
from warpdamp.formats.mode_uff import read_uff, write_uff
from warpdamp.modes import Modes

pyuff = pytest.importorskip("pyuff")
HEAD = "mode,frequency_Hz,modal_mass_kg,x_m,y_m,z_m,u_z\n"
SIX_DIGITS = 1e-5  # of the format's E13.5 fields


@pytest.fixture
def modes():
    """Three modes at four nodes, numbers as an eigensolver gives them."""
    random = np.random.default_rng(1)
    return Modes(
        number=np.array([1, 2, 5]),
        frequency=np.array([39.366612345, 278.97, 1234.5678912]),
        point=random.normal(size=(4, 3)),
        shape=random.normal(size=(3, 4, 3)),
        inherent_damping=np.array([0.001, 0.0, 0.0123]),
        label=np.array([11, 7, 120, 3]),
    ).seen_from(0, (0, 0, 1))


def assert_same(back, modes, rtol):
    assert list(back.number) == list(modes.number)
    assert list(back.label) == list(modes.label)
    for name in ("frequency", "point", "shape", "inherent_damping", "amplitude"):
        np.testing.assert_allclose(getattr(back, name), getattr(modes, name), rtol=rtol)


def test_csv_round_trip(modes, tmp_path):
    write_csv(tmp_path / "modes.csv", modes)
    assert_same(read_csv(tmp_path / "modes.csv"), modes, 0)


def test_uff_round_trip(modes, tmp_path):
    write_uff(tmp_path / "modes.uff", modes)
    assert_same(read_uff(tmp_path / "modes.uff"), modes, SIX_DIGITS)
    assert [p.name for p in tmp_path.iterdir()] == ["modes.uff"]


def nodes_15(modes, length=1.0):
    none = [0] * len(modes.label)
    x, y, z = (length * modes.point).T
    return {
        "type": 15,
        "node_nums": modes.label,
        "def_cs": none,
        "disp_cs": none,
        "color": none,
        "x": x,
        "y": y,
        "z": z,
    }


def mode_2414(modes, k, modal_mass, scale=1.0):
    """A dataset 2414 as analysis codes write it: normal mode, data at nodes, reals."""
    return {
        "type": 2414, "analysis_dataset_label": k + 1, "analysis_dataset_name": "mode", "dataset_location": 1,
        **{f"id{n}": "NONE" for n in range(1, 6)},
        "model_type": 1, "analysis_type": 2, "data_characteristic": 2, "result_type": 8, "data_type": 2,
        "number_of_data_values_for_the_data_component": 3,
        "record10_field6": int(modes.number[k]),
        "record12_field2": modes.frequency[k], "record12_field4": modal_mass,
        "record12_field6": 2 * modes.inherent_damping[k],  # hysteretic damping is twice the ratio
        "node_nums": modes.label[::-1], "data_at_node": list(scale * modes.shape[k, ::-1]),
    }  # fmt: skip


def units(code, length, force):
    return pyuff.prepare_164(code, "of the file", 1, length=length, force=force, temp=1.0, temp_offset=273.15)


@pytest.mark.parametrize(
    ("code", "length", "force", "kilogram"),
    [(1, 1.0, 1.0, 1.0), (5, 1e3, 1e3, 1.0), (7, 39.37007874, 0.2248089431, 0.005710147), (9, 1e3, 1.0, 1e-3)],
    ids=["SI", "mm and mN", "inch and pound force", "mm and N, hence tonnes"],
)
def test_other_datasets_and_units(modes, tmp_path, code, length, force, kilogram):
    """Datasets 15 and 2414, nodes in another order, shapes scaled by 3 to modal mass 9 in the file's unit of mass.

    lbf s^2 / in is 175.1268 kg.
    """
    path = tmp_path / "modes.unv"
    sets = [units(code, length, force), nodes_15(modes, length)]
    sets += [mode_2414(modes, k, 9 * kilogram, scale=3) for k in range(3)]
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")
    assert_same(read_uff(path), modes, 2 * SIX_DIGITS)


def test_modes_without_modal_mass_are_refused_with_the_remedy(modes, tmp_path):
    """0 in the field is what programs write that do not know it; 1 must not be assumed."""
    path = tmp_path / "modes.uff"
    pyuff.UFF(str(path)).write_sets(
        [units(1, 1.0, 1.0), nodes_15(modes), *(mode_2414(modes, k, 0.0) for k in range(3))], mode="overwrite"
    )
    with pytest.raises(ValueError, match=r"modes 1, 2, 5 without modal mass: export .* or give modal_mass"):
        read_uff(path)
    np.testing.assert_allclose(read_uff(path, modal_mass=4.0).shape, modes.shape / 2, rtol=SIX_DIGITS, atol=1e-6)
    with pytest.raises(ValueError, match="2 modal masses for 3 modes"):
        read_uff(path, modal_mass=[1.0, 2.0])

    write_csv(tmp_path / "modes.csv", modes)
    lines = (tmp_path / "modes.csv").read_text().splitlines()
    bare = "\n".join(",".join(cell for k, cell in enumerate(line.split(",")) if k != 2) for line in lines)
    (tmp_path / "bare.csv").write_text(bare)
    with pytest.raises(ValueError, match=r"bare.csv has no modal mass: add a column modal_mass_kg, or give modal_mass"):
        read_csv(tmp_path / "bare.csv")
    assert_same(read_csv(tmp_path / "bare.csv", modal_mass=1.0), modes, 0)
    with pytest.raises(ValueError, match="says the modal mass, and modal_mass says it again"):
        read_csv(tmp_path / "modes.csv", modal_mass=1.0)


def altered(sets, **change):
    return [s | change if s["type"] == 2414 else s for s in sets]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda sets: sets[1:], r"does not say its units \(dataset 164\): give units, one of SI, BG"),
        (lambda sets: [units(1, 3.28, 1.0), *sets[1:]], r"contradicts itself: units 1 \(SI\) have the factors 1 and 1"),
        (lambda sets: [sets[0], *sets[2:]], r"has no nodes"),
        (lambda sets: sets[:2], r"holds no modes \(datasets 55, 2414\), only dataset 164 \(units\), dataset 15 \(nodes\)"),
        (lambda sets: altered(sets, analysis_type=1), r"only .*dataset 2414 \(static\)"),
        (lambda sets: altered(sets, result_type=12), r"mode 1 is not a displacement \(data type 12\)"),
        (lambda sets: altered(sets, node_nums=np.array([1, 2, 3, 4])), r"mode 1 moves node 1, which has no coordinates"),
    ],
    ids=["units", "contradiction", "nodes", "modes", "static", "acceleration", "strangers"],
)  # fmt: skip
def test_universal_files_that_cannot_be_used(modes, tmp_path, change, message):
    path = tmp_path / "modes.uff"
    sets = [units(1, 1.0, 1.0), nodes_15(modes), *(mode_2414(modes, k, 1.0) for k in range(3))]
    pyuff.UFF(str(path)).write_sets(change(sets), mode="overwrite")
    with pytest.raises(ValueError, match=message):
        read_uff(path)


def test_units_may_be_given(modes, tmp_path):
    path = tmp_path / "modes.uff"
    sets = [nodes_15(modes, 1e3), *(mode_2414(modes, k, 1.0) for k in range(3))]
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")
    assert_same(read_uff(path, units="MM"), modes, 2 * SIX_DIGITS)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", r"modes.uff: is no universal file"),
        (b"hello\n", r"modes.uff: is no universal file"),
        (b"    -1\n    55\nNONE\n", r"modes.uff:2: dataset 55 does not end"),
        (b"    -1\n    55\nNONE\n    -1\n", r"modes.uff does not say its units"),
        (b"    -1\n  x\n    -1\n", r"modes.uff:2: expected the number of a dataset, got 'x'"),
    ],
)
def test_what_is_no_universal_file(tmp_path, content, message):
    (tmp_path / "modes.uff").write_bytes(content)
    with pytest.raises(ModalError, match=message):
        read_uff(tmp_path / "modes.uff")
    with pytest.raises(ModalError, match=r"there is no file .*nothing.uff"):
        read_uff(tmp_path / "nothing.uff")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mode,frequency_Hz,modal_mass_kg,x_m,y_m,z_m\n1,40,1,0,0,0\n", r"modes.csv:1: there is no column u_x, u_y or u_z"),
        ("mode,freq,modal_mass_kg,x_m,y_m,z_m,u_z\n1,40,1,0,0,0,1\n", r"modes.csv:1: there is no column frequency_Hz; unknown column freq; the columns are"),
        ("mode,frequency,modal_mass_kg,x_m,y_m,z_m,u_z\n1,40,1,0,0,0,1\n", r"column frequency has no unit: expected hz, khz, rad/s"),
        ("mode,frequency_Hz,modal_mass_kg,x [pt],y_m,z_m,u_z\n1,40,1,0,0,0,1\n", r"column x has the unknown unit pt: expected m, mm"),
        (HEAD + "1,40,1,0,0,0,x\n", r"modes.csv:2: u_z: 'x' is no number"),
        (HEAD + "1,-1,1,0,0,0,1\n", r"modes.csv:2: frequency: -1: expected a frequency of at least 0"),
        (HEAD + "1,nan,1,0,0,0,1\n", r"modes.csv:2: frequency_Hz: 'nan' is not finite"),
        (HEAD + "1.5,40,1,0,0,0,1\n", r"modes.csv:2: mode: 1.5: expected a whole number of at least 1"),
        (HEAD + "1,40,1,0,0,0\n", r"modes.csv:1: 7 names for 6 columns"),
        (HEAD + "1,40,1,0,0,0,1\n2,50,1,0,0,1,1\n", r"mode 2 is not given at the points"),
        (HEAD + "1,40,1,0,0,0,1\n1,41,1,1,0,0,1\n", r"mode 1 has more than one frequency"),
        (HEAD + "1,40,0,0,0,0,1\n", r"mode 1 without modal mass"),
        (HEAD + "1,40,1,0,0,0,0\n", r"mode 1 moves no point"),
        (HEAD.replace("mode,", "mode,damping_ratio,") + "1,1.5,40,1,0,0,0,0\n", r"modes.csv:2: damping_ratio: 1.5: expected a ratio"),
        (HEAD.replace("mode,", "mode,node,") + "1,1,40,1,0,0,0,1\n1,1,40,1,1,0,0,1\n", r"node 1 is there twice in each mode"),
        ("Beam of Monday\n" + HEAD + "1,40,1,0,0,0,1\n", r"modes.csv:1: 'Beam of Monday' is neither names nor units"),
        ("1,40,1,0,0,0,1\n", r"modes.csv:1: has no line of names above the numbers"),
        (HEAD, r"modes.csv: holds no rows of numbers"),
        ("", r"modes.csv: holds no rows of numbers"),
    ],
)  # fmt: skip
def test_tables_that_cannot_be_used(tmp_path, text, message):
    (tmp_path / "modes.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        read_csv(tmp_path / "modes.csv")


def test_a_table_may_be_short(tmp_path):
    """One direction, no nodes, no damping; shapes as measured, 0.36 kg of modal mass at amplitude 1."""
    text = "mode, frequency_Hz, modal_mass_kg, x_m, y_m, z_m, u_z\n1, 40, 0.36, 0, 0, 0, 0.5\n1, 40, 0.36, 0.29, 0, 0, -1\n"
    (tmp_path / "modes.csv").write_text(text)
    modes = read_csv(tmp_path / "modes.csv").at((0.3, 0, 0))
    np.testing.assert_allclose(modes.modal_mass, [0.36])
    assert modes.amplitude[0] > 0
    assert modes.inherent_damping[0] == 0


@pytest.mark.parametrize("encoding", ["utf-8-sig", "cp1252", "utf-16"])
def test_a_table_in_other_dress(tmp_path, encoding):
    """Units in brackets, semicolons, decimal commas: 30 mm, 40 Hz as angular frequency, 360 g, 1 %."""
    text = "# Träger\nMode;Frequency [rad/s];Modal mass [g];damping_ratio [%];x [mm];y_mm;z_m;u_z\n1;251,3274123;360;1;30;0;0;0,5\n"
    (tmp_path / "modes.csv").write_bytes(text.encode(encoding))
    modes = read_csv(tmp_path / "modes.csv")
    np.testing.assert_allclose(modes.frequency, [40.0], rtol=1e-9)
    np.testing.assert_allclose(modes.modal_mass, [0.36 / 0.5**2])
    np.testing.assert_allclose((modes.inherent_damping[0], modes.point[0, 0]), (0.01, 0.03))
