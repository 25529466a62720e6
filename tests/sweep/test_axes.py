"""Any scalar, by its path, is an axis; what is wrong with a sweep is said at its line."""

import re

import numpy as np
import pytest

from conftest import ROOT
from warpdamp import ConfigError, load
from warpdamp.execution.batching import batches
from warpdamp.sweep.cases import Cases
from warpdamp.sweep.plan import Fate, make_plan
from warpdamp.sweep.reader import read_axes
from warpdamp.sweep.resolve import self_contained

BASE = """
damper:
  enclosure: {diameter: 24 mm, height: 20 mm, material: pmma}
  particles: {count: 16, radius: 3.73 mm, material: pmma}
materials:
  pmma: {density: 920 kg/m^3, youngs_modulus: 330 MPa, poissons_ratio: 0.37}
contact: {restitution: 0.52, friction: 0.5}
excitation: {gamma: [3, 6], frequency: [40 Hz, 80 Hz]}
preparation: loose
steady_state: {fewest_cycles: 12, most_cycles: 12}
"""


@pytest.fixture
def study(tmp_path):
    def written(sweep, base=BASE):
        path = tmp_path / "study.yaml"
        path.write_text(f"{base}sweep:\n{sweep}" if sweep else base)
        return path

    return written


def rows(config):
    return {axis.name: axis.rows for axis in read_axes(config)[1]}


def test_a_product_of_lists_and_ranges(study):
    path = study(
        "  product:\n"
        "    contact.friction: [0.1, 0.3, 0.86]\n"
        "    materials.pmma.youngs_modulus: {log: [33 MPa, 3.3 GPa], n: 3}\n"
        "    particles.count: {from: 8, to: 12, n: 3}\n"
        "    preparation: [loose, carried]\n"
        "    gamma: {from: 1, to: 3, n: 5}\n"
        "    seed: [4, 2]\n",
        BASE.replace("gamma: [3, 6]", "gamma: 3"),
    )
    config = load(path)
    assert rows(config) == {
        "friction": ((0.1,), (0.3,), (0.86,)),
        "youngs_modulus": ((33e6,), (pytest.approx(330e6),), (3.3e9,)),
        "count": ((8,), (10,), (12,)),
        "preparation": (("loose",), ("carried",)),
    }
    cases = Cases(config)
    assert cases.dims == ("frequency", "gamma", "friction", "youngs_modulus", "count", "preparation", "seed")
    assert cases.gammas == [1, 1.5, 2, 2.5, 3]
    assert cases.seeds == [2, 4]
    spec, _ = cases.spec(len(cases) - 1)
    assert len(spec.bed.grains) == 12
    assert spec.bed.seed == 4
    assert spec.scene.pair_surface(0, 0).friction == 0.86
    assert spec.scene.drive.frequency == 80


def test_numbers_and_cases_belong_together(study):
    cases = Cases(load(study("  product: {contact.friction: [0.1, 0.3], seed: [1, 2]}\n")))
    seen = {}
    for point in cases.points():
        for number, position in cases.numbers(point):
            seen[number] = cases.spec_at(point, position)[0]
    assert sorted(seen) == list(range(len(cases)))
    assert all(cases.spec(number)[0] == spec for number, spec in seen.items())


def test_ranges_stand_where_values_stand(study):
    text = BASE.replace("friction: 0.5", "friction: {from: 10 %, to: 0.3, n: 3}")
    text = text.replace("frequency: [40 Hz, 80 Hz]", "frequency: {from: 30 Hz, to: 680 Hz, n: 27}")
    config = load(study("", text))
    assert config.contact.friction == pytest.approx([0.1, 0.2, 0.3])
    assert config.excitation.frequency == list(np.arange(30.0, 681.0, 25.0))


def test_zipped_groups_share_a_dimension(study):
    config = load(
        study(
            "  zip:\n    - {contact.friction: [0.1, 0.3], density: [920, 1 g/cm^3]}\n    - {height: [20 mm, 25 mm]}\n"
        )
    )
    (axis,) = read_axes(config)[1]
    assert axis.name == "case"
    assert axis.rows == tuple((f, pytest.approx(d), h) for f, d in ((0.1, 920), (0.3, 1000)) for h in (0.02, 0.025))


def test_the_examples_of_the_documentation_are_valid(tmp_path):
    page = (ROOT / "docs" / "howto" / "sweep-anything.md").read_text()
    examples = re.findall(r"```yaml\n(sweep:.*?)```", page, re.DOTALL)
    (tmp_path / "points.csv").write_text("rolling_friction\n0.01\n")
    base = (ROOT / "configs" / "beam.yaml").read_text()
    shapes = []
    for example in examples:
        (tmp_path / "study.yaml").write_text(base + example)
        cases = Cases(load(tmp_path / "study.yaml"))
        shapes.append(dict(zip(cases.dims[2:-1], cases.shape[2:-1], strict=True)))
    assert shapes == [{"friction": 3, "count": 3, "preparation": 2, "case": 2}, {"case": 64}, {"case": 1}]


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
def test_samples_fill_their_ranges_evenly(study, method):
    config = load(
        study(
            f"  sample:\n    method: {method}\n    n: 32\n    over:\n      contact.friction: [0.2, 0.6]\n"
            "      materials.pmma.youngs_modulus: {log: [33 MPa, 3.3 GPa]}\n      gamma: [1, 5]\n",
            BASE.replace("gamma: [3, 6]", "gamma: 3"),
        )
    )
    (axis,) = read_axes(config)[1]
    friction, modulus, gamma = (np.array(column) for column in zip(*axis.rows, strict=True))
    for part in ((friction - 0.2) / 0.4, np.log10(modulus / 33e6) / 2, (gamma - 1) / 4):
        assert sorted(np.floor(32 * part)) == list(range(32))  # one in every 32nd part: both designs promise that
    assert Cases(config).shape == (2, 1, 32, 1)
    assert read_axes(config)[1][0].rows == axis.rows  # the same each time


def test_a_table(study, tmp_path):
    (tmp_path / "points.csv").write_text("contact.friction,excitation.frequency,seed\n10 %,50 Hz,3\n0.2,0.06 kHz,4\n")
    config = load(study("  csv: points.csv\n", BASE.replace("[40 Hz, 80 Hz]", "40 Hz")))
    assert rows(config)["case"] == ((0.1, 50.0, 3), (0.2, pytest.approx(60.0), 4))
    (tmp_path / "points.csv").unlink()
    with pytest.raises(ConfigError, match=r"study.yaml:\d+:\d+: sweep.csv: there is no file .*points.csv"):
        self_contained(config)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("mark", [";", "\t"])
def test_tables_as_spreadsheets_write_them(study, tmp_path, encoding, mark):
    """Decimal commas, units in the heads, and a comment that is ASCII in no encoding."""
    rows_ = ["# Reibung µ, §", f"contact.friction [%]{mark}height [mm]", f"10,5{mark}20,5", f"20{mark}21"]
    (tmp_path / "points.csv").write_bytes("\r\n".join(rows_).encode(encoding))
    config = load(study("  csv: points.csv\n"))
    assert rows(config)["case"] == ((pytest.approx(0.105), pytest.approx(0.0205)), (0.2, pytest.approx(0.021)))


def test_a_column_of_quantities_has_no_blanks_for_separators(study, tmp_path):
    (tmp_path / "points.csv").write_text("height\n20 mm\n21 mm\n22 mm\n")
    assert rows(load(study("  csv: points.csv\n")))["case"] == ((0.02,), (0.021,), (0.022,))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("contact.frction\n0.1\n", r"points.csv:1: column 'contact.frction': is not a scalar.*did you mean 'contact.friction'"),
        ("friction,contact.friction\n0.1,0.2\n", r"points.csv:1: column 'contact.friction': is given in sweep.csv, too"),
        ("friction,height\n0.1\n", r"points.csv:2: 1 values for 2 columns"),
        ("friction\n-1\n", r"points.csv:2: .*greater than or equal to 0"),
        ("friction;height\n0,1;20 mm\n0.2;20 mm\n", r"points.csv:3: has decimal points and decimal commas"),
        ("height [kg]\n20\n", r"points.csv:2: .*wrong unit"),
        ("height [mm]\n20 mm\n", r"points.csv:2: .*20 mm"),
        ("friction\n", "needs a line of paths"),
        ("friction\nnan\n", r"points.csv:2: .*nan"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_names_its_line(study, tmp_path, text, message):
    (tmp_path / "points.csv").write_text(text)
    with pytest.raises(ConfigError) as caught:
        load(study("  csv: points.csv\n"))
    assert re.search(r"study.yaml:\d+:\d+: sweep.csv: .*" + message, str(caught.value)), str(caught.value)
    assert "\n" not in str(caught.value)


def test_exclusions_and_combinations_that_cannot_be(study):
    made = make_plan(
        Cases(
            load(
                study(
                    "  product: {contact.friction: [0.1, 0.3], height: [20 mm, 30 mm], count: [16, 40]}\n"
                    "  exclude:\n    - {friction: 10 %, gamma: {from: 5, to: 9}}\n    - {frequency: 80 Hz, height: 30 mm}\n"
                )
            )
        )
    )
    fate = made.fate.reshape(made.cases.shape)  # frequency, gamma, friction, height, count, seed
    refused = np.zeros(fate.shape, bool)
    refused[:, :, :, 0, 1] = True  # 40 spheres fill 0.96 of 20 mm
    assert np.array_equal(fate == Fate.REFUSED, refused)
    excluded = np.zeros(fate.shape, bool)
    excluded[:, 1, 0] = True
    excluded[1, :, :, 1] = True
    assert np.array_equal(fate == Fate.EXCLUDED, excluded & ~refused)
    assert "too many particles" in next(iter(made.refused.values()))


def test_a_study_of_which_everything_is_excluded_is_refused(study):
    swept = "  product: {contact.friction: [0.1, 0.3]}\n  exclude: [{friction: {from: 0, to: 1}}]\n"
    with pytest.raises(ConfigError, match=r"study.yaml:13:\d+: sweep.exclude: leaves no case to run"):
        make_plan(Cases(load(study(swept))))


def test_a_damper_on_a_node_is_one_combination_that_cannot_be(config_path, tmp_path):
    """Mode 2 of a symmetric beam has a node at its centre: there only; where nothing of it is swept, that stops the study."""
    text = config_path.read_text().replace("modes: [1, 3, 5]", "modes: [1, 2]")
    path = tmp_path / "study.yaml"
    path.write_text(text + "sweep: {product: {point_mass.position: [200 mm, 290 mm]}}\n")
    made = make_plan(Cases(load(path)))
    fate = made.fate.reshape(made.cases.shape)  # frequency, gamma, position, seed
    assert (fate[:, :, 1] == Fate.REFUSED).all()
    assert (fate[:, :, 0] != Fate.REFUSED).all()
    assert "mode 2 has a node where the damper sits" in made.refused[(1,)]
    path.write_text(text + "sweep: {product: {contact.friction: [0.1, 0.2]}}\n")
    with pytest.raises(ConfigError, match="mode 2 has a node"):
        make_plan(Cases(load(path)))


def test_a_case_is_known_by_what_it_depends_on(study):
    """The same key in another sweep; another key for another physics, step, criterion or history."""
    small, large = (
        make_plan(Cases(load(study(f"  product: {{contact.friction: {f}}}\n")))) for f in ("[0.3]", "[0.1, 0.3]")
    )
    assert set(small.keys) < set(large.keys)
    assert len(set(large.keys)) == len(large.keys) == 8
    longer = make_plan(Cases(load(study("  product: {contact.friction: [0.3], most_cycles: [13]}\n"))))
    assert not set(longer.keys) & set(large.keys)

    def carried(gammas):
        text = BASE.replace("loose", "carried").replace("gamma: [3, 6]", f"gamma: {gammas}")
        made = make_plan(Cases(load(study("", text))))
        return dict(zip(((g, f) for f in (40, 80) for g in made.cases.gammas), made.keys, strict=True))

    few, more = carried([3, 6]), carried([1, 3, 6])
    assert not set(few.values()) & set(more.values())  # each starts from another history
    assert carried([3, 6, 9]).items() >= few.items()


def test_a_kept_plan_is_the_plan(study, tmp_path, monkeypatch):
    """Read back by the folder's own study without making it again; made again when it is damaged."""
    from warpdamp.sweep import plan as planning
    from warpdamp.sweep import stored as loading

    text = BASE.replace("preparation: loose", "preparation: carried").replace(
        "[40 Hz, 80 Hz]", "{log: [40 Hz, 81 Hz], n: 3}"
    )
    sweep = "  product: {friction: {from: 10 %, to: 0.7, n: 3}, height: [20 mm, 7.47 mm]}\n  exclude: [{gamma: 3, friction: 0.1}]\n"
    made = make_plan(Cases(load(study(sweep, text))))
    planning.save_plan(made, tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(planning, "make_plan", None)
        kept = loading.load_plan(tmp_path)
    for again in (kept, planning.load_or_make_plan(made.cases, tmp_path)):
        for name in planning._ARRAYS:
            np.testing.assert_array_equal(getattr(again, name), getattr(made, name))
        assert (again.groups, again.beds, again.refused, again.attributes) == (
            made.groups,
            made.beds,
            made.refused,
            made.attributes,
        )
    content = bytearray((tmp_path / "plan.npz").read_bytes())
    content[len(content) // 2] ^= 255
    (tmp_path / "plan.npz").write_bytes(content)
    assert (loading.load_plan(tmp_path).keys == made.keys).all()


def test_the_physics_is_part_of_the_key(study, monkeypatch):
    from warpdamp.damper import case
    from warpdamp.sweep import plan as planning

    before = make_plan(Cases(load(study("")))).keys
    for module in (case, planning):
        monkeypatch.setattr(module, "PHYSICS_VERSION", 999)
    assert not set(before) & set(make_plan(Cases(load(study("")))).keys)


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ("  product: {contact.frction: [1, 2]}\n", r"12:13: sweep.product.contact.frction: is not a scalar.*did you mean 'contact.friction'"),
        ("  product: {contact.friction: [0.1, -1]}\n", r"sweep.product.contact.friction.1: .*greater than or equal to 0"),
        ("  product: {contact.friction: [0.1, 10 %]}\n", r"each value once"),
        ("  product: {height: [10 mm, 20 kg]}\n", r"sweep.product.height.1: .*wrong unit"),
        ("  product: {gamma: [1, 2]}\n", r"is a list at excitation.gamma already"),
        ("  product: {material: [pmma]}\n", r"may be damper.enclosure.material or damper.particles.material"),
        ("  product: {friction: {log: [0, 1], n: 3}}\n", r"must be positive"),
        ("  product: {friction: {from: 0, to: 1}}\n", r"sweep.product.friction"),
        ("  product: {preparation: {from: 1, to: 2, n: 3}}\n", r"'1' is not one of|Input should be|input should be"),
        ("  product: {friction: [0.1, 0.2]}\n  zip: [{contact.friction: [1, 2]}]\n", r"sweep.zip.0.contact.friction: is given in sweep.product.friction, too"),
        ("  zip: [{friction: [0.1, 0.2], restitution: [0.5]}]\n", r"need as many values each, got contact.friction 2, contact.restitution 1"),
        ("  sample: {n: 4, over: {friction: [0.5, 0.5]}}\n", r"sweep.sample.over.friction: the ends of a range must differ"),
        ("  sample: {n: 4, method: random, over: {friction: [0, 1]}}\n", r"'random' is not one of 'sobol' or 'latin_hypercube'"),
        ("  exclude: [{frictoin: 1}]\n", r"sweep.exclude.0.frictoin: is not a scalar"),
        ("  exclude: [{gamma: 3}, {friction: 0.7}]\n", r"12:26: sweep.exclude.1.friction: leaves nothing out: no case has such a value of contact.friction"),
        ("  exclude: [{gamma: {from: 10, to: 14}}]\n", r"sweep.exclude.0.gamma: leaves nothing out"),
        ("  product: {}\n", r"sweep: nothing is swept"),
        ("  produt: {}\n", r"sweep.produt: unknown key; did you mean 'product'\?"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_line(study, sweep, message):
    with pytest.raises(ConfigError) as caught:
        load(study(sweep))
    said = str(caught.value)
    assert re.search(message, said), said
    assert re.match(r".*study.yaml:\d+:\d+: ", said)
    assert "\n" not in said


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_batches_leave_no_worker_alone(study, workers):
    """64 equal cases, dealt to whoever is free: all finish within one case of each other."""
    many = "  product: {gamma: {from: 1, to: 5, n: 64}}\n"
    made = make_plan(
        Cases(load(study(many, BASE.replace("gamma: [3, 6], frequency: [40 Hz, 80 Hz]", "gamma: 1, frequency: 40 Hz"))))
    )
    made.cost[:] = 1.0
    dealt = [len(batch) for batch in batches(made, made.to_run(), workers)]
    assert sum(dealt) == 64
    busy = np.zeros(workers)
    for cases in dealt:
        busy[np.argmin(busy)] += cases
    assert np.ptp(busy) <= 1
    assert len(dealt) <= 8 + 8 * workers


def test_what_is_alike_is_dealt_once(study):
    """Cases of one key run once, and batches shrink with what is really left."""
    base = BASE.replace("gamma: [3, 6]", "gamma: 1")
    alike = make_plan(Cases(load(study("  product: {gamma: {from: 1, to: 5, n: 16}, seed: [1, 2]}\n", base))))
    alike.cost[:] = 1.0
    alike.keys[1::2] = alike.keys[::2]
    dealt = [len(batch) for batch in batches(alike, alike.to_run(), 2)]
    assert sum(dealt) == 32
    assert max(dealt) == 8
