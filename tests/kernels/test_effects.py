"""Each effect against a closed form or a conservation law, and off against absent.

Off and absent: kernels with an effect and its parameter at zero must move a bed as kernels without it do.  They are
other machine code, so last bits may differ, and a bed multiplies differences by ten every few contacts: hence short runs
and 1e-9.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq

from warpdamp import Batch, Case, Cylinder, Drive, Effects, Material, Scene, Simulation, State, Surface
from warpdamp.engine.ledger import maximum_energy
from warpdamp.numerics.timestep import steps_per_cycle
from warpdamp.scene.contact import contact_constants
from warpdamp.scene.effects import called_for, covering
from warpdamp.scene.paper import PMMA, RADIUS

G = 9.81
STEEL = Material(density=7800, youngs_modulus=210e9, poissons_ratio=0.3)
WIDE = Cylinder(0.4, 0.04)


def resting_height(scene):
    """Of a ball on the floor under its weight."""
    k = 4 / 3 * contact_constants(scene.particle, scene.wall, scene.wall_contact)["modulus"] * math.sqrt(RADIUS)
    return RADIUS - (float(scene.mass(RADIUS)) * G / k) ** (2 / 3)


def after(scene, state, dt, time, effects=None):
    simulation = Simulation(scene, state, dt, effects=effects)
    simulation.advance(round(time / dt))
    return simulation.read()


def rolling_ball(scene, speed):
    state = State.at_rest([[-0.05, 0, resting_height(scene)]], RADIUS)
    state.velocity[0, 0] = speed
    state.spin[0, 1] = speed / RADIUS
    return state


def with_rolling(scene, coefficient):
    surface = dataclasses.replace(scene.wall_contact, rolling_friction=coefficient)
    return dataclasses.replace(scene, particle_contact=surface, wall_contact=surface)


# ---- what is called for ----------------------------------------------------------------------------------------------


def test_effects_follow_the_scene(damper):
    state = State.at_rest([[0, 0, 0.01], [0, 0, 0.02]], RADIUS)
    full = called_for(damper(46.0, 1.0), state)
    assert full == Effects()
    assert called_for(damper(), state) == dataclasses.replace(full, indicators=False)
    scene = damper(46.0, 1.0)
    frictionless = dataclasses.replace(scene, particle_contact=Surface(0.5, 0), wall_contact=Surface(0.5, 0))
    assert called_for(frictionless, state) == dataclasses.replace(full, friction=False, rotation=False)
    elastic = dataclasses.replace(scene, particle_contact=Surface(1, 0.1), wall_contact=Surface(1, 0.1))
    assert called_for(elastic, state) == dataclasses.replace(full, dashpots=False)
    assert called_for(with_rolling(scene, 0.1), state).rolling
    assert not called_for(with_rolling(frictionless, 0.1), state).rolling  # nothing can turn a particle there
    assert not called_for(dataclasses.replace(scene, gravity=(0, 0, 0)), state).gravity
    assert not called_for(dataclasses.replace(scene, enclosure=Cylinder(1, 1, lid=False)), state).lid
    assert called_for(scene, State.at_rest(state.position, [RADIUS, RADIUS / 2])).sizes
    mixed = dataclasses.replace(scene, particle=(PMMA, STEEL))
    assert called_for(mixed, state).materials


def test_forcing_and_covering():
    assert Effects().forced({"rotation": False}) == dataclasses.replace(Effects(), rotation=False)
    assert not Effects(rolling=True).forced({"rotation": False}).rolling
    with pytest.raises(ValueError, match="'lid' cannot be forced; choose from friction"):
        Effects().forced({"lid": False})
    both = covering([Effects(friction=False, rotation=False), Effects(dashpots=False)])
    assert both == Effects()
    with pytest.raises(ValueError, match="one precision"):
        covering([Effects(), Effects(precision="float32")])


def test_every_effect_can_be_told_off_and_on():
    """The table of effects is what the fields, the toggles and the timings are made of."""
    from warpdamp.config.damper import EffectsConfig
    from warpdamp.scene.effects import EFFECTS, FORCIBLE
    from warpdamp.study.speeds import TOGGLES, without

    assert [f.name for f in dataclasses.fields(Effects)] == [*EFFECTS, "precision", "device"]
    assert [*EffectsConfig.model_fields] == [*(name for name in FORCIBLE if name != "channels"), "ledger"]
    everything = Effects(**dict.fromkeys(EFFECTS, True))
    for name in TOGGLES:
        less = without(everything, name)
        assert less.rotation or not less.rolling
        for other, effect in EFFECTS.items():
            assert not getattr(less, other) or all(getattr(less, need) for need in effect.needs)
        assert less != everything


def test_what_is_off_has_no_array():
    from warpdamp.kernels.structs import types

    plain = types(
        Effects(friction=False, rotation=False, dashpots=False, gravity=False, channels=False, indicators=False)
    )
    assert list(plain.Particle.vars) == ["position", "half_velocity", "force", "listed"]
    assert list(plain.Contacts.vars) == ["start", "owner", "partner", "nearby", "touching", "touching_walls"]
    assert list(plain.Law.vars) == ["modulus"]
    assert "gravity" not in plain.Case.vars
    assert len(plain.Losses()) == 1


# ---- off is as absent ------------------------------------------------------------------------------------------------

SAME = [
    ("friction at mu = 0", {"friction": 0.0}, {"friction": True, "rotation": True}),
    ("dashpots at e = 1", {"restitution": 1.0}, {"dashpots": True}),
    ("rolling at 0", {}, {"rolling": True}),
    ("gravity of 0", {"gravity": (0.0, 0.0, 0.0)}, {"gravity": True}),
    ("sizes all alike", {}, {"sizes": True}),
    ("one material as a mixture", {}, {"materials": True}),
    ("losses in total", {}, {"channels": False}),
    ("no indicators", {}, {"indicators": False}),
    ("no guards", {}, {"guards": False}),
]


@pytest.mark.parametrize(("name", "change", "more"), SAME, ids=[name for name, _, _ in SAME])
def test_an_effect_at_zero_moves_nothing(make_scene, loose_positions, name, change, more):
    scene = make_scene(**{"gravity": (0, 0, -G)} | change, enclosure=Cylinder(0.04, 0.04), drive=Drive(46.0, 6 * G))
    state = State.at_rest(loose_positions(1), RADIUS)
    state.velocity[:] = np.random.default_rng(1).normal(scale=0.3, size=(120, 3))
    own = called_for(scene, state)
    other = dataclasses.replace(own, **more)
    assert own != other
    dt = 1 / 46 / 12_000
    results = []
    for effects in (own, other):
        batch = Batch([Case(scene, state, dt)], effects=effects)
        batch.advance(600)
        results.append(batch.read()[0])
    (alone, ledger), (forced, forced_ledger) = results
    assert len(alone.pairs) > 5 or not own.history  # some meet
    moved = np.abs(alone.velocity).max()
    np.testing.assert_allclose(forced.velocity, alone.velocity, atol=1e-9 * moved)
    np.testing.assert_allclose(forced.position, alone.position, atol=1e-12)
    assert forced_ledger.dissipated[0] == pytest.approx(ledger.dissipated[0], rel=1e-7, abs=1e-18)
    assert forced_ledger.stored[0] == pytest.approx(ledger.stored[0], rel=1e-9)


# ---- each against what is known --------------------------------------------------------------------------------------


def test_without_friction_the_way_along_the_wall_is_kept(make_scene):
    scene = make_scene(0.5, 0.0, enclosure=WIDE)
    state = State.at_rest([[0, 0, RADIUS + 1e-6]], RADIUS)
    state.velocity[0] = [0.3, 0.1, -0.5]
    now, ledger = after(scene, state, 1e-7, 4e-4)
    assert now.velocity[0, :2] == pytest.approx([0.3, 0.1], rel=1e-15)
    assert now.velocity[0, 2] == pytest.approx(0.25, rel=2e-3)
    assert not now.spin.any()
    assert ledger.dissipated[-1] == pytest.approx(ledger["wall_normal_dashpot"][-1])


def test_a_ball_that_cannot_turn_slides_to_a_stop(make_scene):
    """v = v0 - mu g t all the way, where a turning ball would roll on at 5/7 v0."""
    friction, speed = 0.2, 0.1
    scene = make_scene(0.5, friction, enclosure=WIDE, gravity=(0, 0, -G))
    state = State.at_rest([[-0.01, 0, resting_height(scene)]], RADIUS)
    state.velocity[0, 0] = speed
    effects = called_for(scene, state).forced({"rotation": False})
    stop = speed / (friction * G)
    sliding, _ = after(scene, state, 2e-6, 0.8 * stop, effects)
    assert sliding.velocity[0, 0] == pytest.approx(0.2 * speed, rel=5e-3)
    stopped, ledger = after(scene, state, 2e-6, 1.5 * stop, effects)
    assert abs(stopped.velocity[0, 0]) < 1e-4 * speed
    assert not stopped.spin.any()
    assert ledger.dissipated[-1] == pytest.approx(0.5 * float(scene.mass(RADIUS)) * speed**2, rel=5e-3)


def test_an_elastic_bed_keeps_its_energy(make_scene, loose_positions):
    """The leapfrog's energy error stays bounded: 30 contact times at 60 steps each move it by less than 1e-3."""
    scene = make_scene(1.0, 0.0, enclosure=Cylinder(0.04, 0.04))
    state = State.at_rest(loose_positions(2), RADIUS)
    state.velocity[:] = np.random.default_rng(1).normal(scale=0.3, size=(120, 3))
    _, ledger = after(scene, state, 8e-7, 5e-3)
    assert not called_for(scene, state).dashpots
    assert ledger.dissipated[-1] == 0
    assert ledger.stored[-1] == pytest.approx(ledger.stored[0], rel=1e-3)
    assert ledger["kinetic_translation"][-1] < ledger["kinetic_translation"][0]  # some are touching


@pytest.mark.parametrize("missing", ["side", "floor", "lid"])
def test_a_missing_wall_lets_through(make_scene, missing):
    """Past the missing wall the flight is a parabola; with the wall it is not."""
    velocity = {"side": [1.0, 0, 0.2], "floor": [0, 0, -0.5], "lid": [0.0, 0, 1.0]}[missing]
    t = 0.05
    for there in (False, True):
        scene = make_scene(0.5, 0.0, enclosure=Cylinder(0.04, 0.04, **{missing: there}), gravity=(0, 0, -G))
        state = State.at_rest([[0, 0, 0.02]], RADIUS)
        state.velocity[0] = velocity
        now, _ = after(scene, state, 1e-6, t)
        flight = [0.02 * k + v * t + g * t**2 / 2 for k, v, g in zip((0, 0, 1), velocity, (0, 0, -G), strict=True)]
        assert np.allclose(now.position[0], flight, atol=1e-12) is not there


def test_a_drive_across_the_axis_is_an_impact_damper_across_the_cavity(make_scene):
    """One ball between opposite sides, no gravity: pi K cos p + 2 sin p = 1/q, K = (1+e)/(1-e), eps = K cos^2 p.

    Along x and y, where symmetry holds the ball on the diameter.  At 10 Hz and a clearance of 20 mm; contacts last a few 1e-5 of the period, and 1e-6 s is 1/40 of them: 1 %.
    """
    restitution, clearance, q = 0.52, 0.02, 0.2
    cavity = Cylinder(clearance + 2 * RADIUS, 0.04)
    frequency = 10.0
    acceleration = q * clearance * (2 * math.pi * frequency) ** 2
    ratio = (1 + restitution) / (1 - restitution)
    p = brentq(lambda p: math.pi * ratio * math.cos(p) + 2 * math.sin(p) - 1 / q, -math.pi / 2, 0.0)
    for direction in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0)):
        scene = make_scene(restitution, 0.0, enclosure=cavity, drive=Drive(frequency, acceleration, direction))
        start = 0.3 * clearance * np.array(direction) + [0, 0, 0.02]
        state = State.at_rest([start], RADIUS)
        batch = Batch([Case(scene, state, 1 / frequency / 100_000)], max_rows=41)
        batch.advance(40 * 100_000)
        found = batch.cycles(0).per_cycle()[25:].mean() / maximum_energy(scene.drive, float(scene.mass(RADIUS)))
        assert found == pytest.approx(ratio * math.cos(p) ** 2, rel=0.01)


def test_species_meet_as_each_pair_of_them_should(make_scene, two_spheres):
    """Restitutions of PMMA-PMMA, PMMA-steel, steel-steel, and each against the wall, all in one scene."""
    pairs = {(0, 0): 0.3, (0, 1): 0.6, (1, 1): 0.9}
    walls = {0: 0.4, 1: 0.8}
    surfaces = tuple(tuple(Surface(pairs[min(i, j), max(i, j)], 0.0) for j in (0, 1)) for i in (0, 1))
    scene = Scene((PMMA, STEEL), STEEL, surfaces, tuple(Surface(walls[i], 0.0) for i in (0, 1)), None, (0.0, 0.0, 0.0))
    assert called_for(scene, two_spheres(1.0)).materials
    for (i, j), restitution in pairs.items():
        state = two_spheres(1.0)
        state.species[:] = [i, j]
        now, _ = after(scene, state, 2e-8, 1.2e-4)
        assert now.velocity[1, 0] - now.velocity[0, 0] == pytest.approx(restitution, abs=2e-3)
        mass = scene.mass(state.radius, state.species)
        assert mass @ now.velocity[:, 0] == pytest.approx(mass @ state.velocity[:, 0], rel=1e-12)
    boxed = dataclasses.replace(scene, enclosure=WIDE)
    for species, restitution in walls.items():
        state = State.at_rest([[0, 0, RADIUS + 1e-6]], RADIUS, species)
        state.velocity[0, 2] = -0.5
        now, _ = after(boxed, state, 5e-8, 3e-4)
        assert now.velocity[0, 2] == pytest.approx(0.5 * restitution, rel=5e-3)


def test_a_mixture_weighs_what_its_species_weigh():
    scene = Scene((PMMA, STEEL), STEEL, Surface(0.5, 0.1), Surface(0.5, 0.1), WIDE)
    state = State.at_rest([[0, 0, 0.01], [0.01, 0, 0.01]], [RADIUS, RADIUS / 2], [1, 0])
    volume = 4 / 3 * math.pi * np.array([RADIUS, RADIUS / 2]) ** 3
    assert scene.masses(state) == pytest.approx([7800 * volume[0], 920 * volume[1]])
    with pytest.raises(ValueError, match="2 rows of 2 surfaces"):
        dataclasses.replace(scene, particle_contact=((Surface(0.5, 0.1),),))


def test_rolling_resistance_brakes_a_rolling_ball(make_scene):
    """a = 5/7 mu_r g; then it stands still, and all its energy is in the channel of rolling."""
    coefficient, speed = 0.05, 0.05
    scene = with_rolling(make_scene(0.5, 0.8, enclosure=WIDE, gravity=(0, 0, -G)), coefficient)
    state = rolling_ball(scene, speed)
    braking = 5 / 7 * coefficient * G
    stop = speed / braking
    now, _ = after(scene, state, 2e-6, 0.6 * stop)
    assert now.velocity[0, 0] == pytest.approx(0.4 * speed, rel=2e-2)  # the rolling spring takes its time to load
    ended, ledger = after(scene, state, 2e-6, 1.6 * stop)
    assert abs(ended.velocity[0, 0]) < 2e-3 * speed
    kinetic = 0.7 * float(scene.mass(RADIUS)) * speed**2
    assert ledger["wall_rolling"][-1] == pytest.approx(kinetic, rel=1e-2)
    assert abs(ledger.residual[-1]) < 2e-3 * kinetic
    free, _ = after(make_scene(0.5, 0.8, enclosure=WIDE, gravity=(0, 0, -G)), state, 2e-6, 0.6 * stop)
    assert free.velocity[0, 0] == pytest.approx(speed, rel=1e-3)


@pytest.mark.parametrize("angle", [2.0, 6.0])
def test_rolling_resistance_holds_on_a_gentle_slope(make_scene, angle):
    """tan(angle) against mu_r = 0.06 (3.4 degrees): rest below, a = 5/7 g (sin - mu_r cos) above."""
    coefficient, tilt = 0.06, math.radians(angle)
    gravity = (G * math.sin(tilt), 0.0, -G * math.cos(tilt))
    scene = with_rolling(make_scene(0.5, 0.8, enclosure=WIDE, gravity=gravity), coefficient)
    state = State.at_rest([[-0.05, 0, resting_height(scene)]], RADIUS)
    time = 0.05
    now, _ = after(scene, state, 2e-6, time)
    free = 5 / 7 * G * (math.sin(tilt) - coefficient * math.cos(tilt))
    if free < 0:
        assert abs(now.position[0, 0] + 0.05) < 1e-6  # the springs give by less than a micrometre
    else:
        assert now.velocity[0, 0] == pytest.approx(free * time, rel=2e-2)


def test_rolling_resistance_keeps_momenta_and_never_heats(make_scene, two_spheres):
    state = two_spheres(1.0, (RADIUS, RADIUS / 3))
    state.position[:, 1] = [-0.8e-3, 0.8e-3]
    state.spin[:] = [[10, 20, 30], [-100, 50, 200]]
    scene = with_rolling(make_scene(0.7, 0.4), 0.3)
    mass = scene.masses(state)[:, None]

    def momenta(s):
        inertia = 0.4 * mass * s.radius[:, None] ** 2
        return (mass * s.velocity).sum(0), (mass * np.cross(s.position, s.velocity) + inertia * s.spin).sum(0)

    now, ledger = after(scene, state, 2e-7, 5e-4)
    assert ledger["particle_rolling"][-1] > 0
    for name in ledger.losses:
        assert ledger[name][-1] >= -1e-18
    for got, expected in zip(momenta(now), momenta(state), strict=True):
        np.testing.assert_allclose(got, expected, atol=1e-13 * float(np.abs(mass * state.velocity).max()))
    assert abs(ledger.residual[-1]) < 2e-3 * ledger.dissipated[-1]


def test_rolling_resistance_shows_in_a_bed_and_its_ledger_closes(damper, loose_positions):
    scene = with_rolling(damper(46.0, 3.0), 0.1)
    state = State.at_rest(loose_positions(1), RADIUS)
    n = steps_per_cycle(scene, state)
    batch = Batch([Case(scene, state, 1 / 46 / n)], max_rows=5)
    batch.advance(4 * n)
    ledger = batch.cycles(0)
    assert ledger["particle_rolling"][-1] > 0.02 * ledger.dissipated[-1]
    assert abs(ledger.residual[-1]) < 0.01 * ledger.dissipated[-1]


def test_states_of_mixtures_and_of_rolling_go_on_from_where_they_were_read(make_scene):
    """What is read back and started again remembers springs, rolls and species."""
    surfaces = tuple(tuple(Surface(0.5, 0.5, 0.1) for _ in range(2)) for _ in range(2))
    scene = Scene((PMMA, STEEL), PMMA, surfaces, (Surface(0.5, 0.5, 0.1),) * 2, Cylinder(0.03, 0.03))
    rng = np.random.default_rng(2)
    from warpdamp.damper.placement import separate

    radius = rng.uniform(2e-3, 3e-3, 40)
    state = State.at_rest(separate(radius, scene.enclosure, 1), radius, rng.integers(0, 2, 40))
    batch = Batch([Case(scene, state, 5e-7)])
    batch.advance(60_000)
    rested, _ = batch.read()[0]
    assert np.any(rested.pair_history.roll)
    assert np.any(rested.wall_history.roll)
    again = Batch([Case(scene, rested, 5e-7)]).read()[0][0]
    for name in ("position", "velocity", "spin", "species"):
        np.testing.assert_array_equal(getattr(again, name), getattr(rested, name))
    order, back = (np.lexsort(s.pairs.T) for s in (again, rested))
    for name in ("stretch", "radius", "roll"):
        np.testing.assert_array_equal(getattr(again.wall_history, name), getattr(rested.wall_history, name))
        np.testing.assert_array_equal(
            getattr(again.pair_history[order], name), getattr(rested.pair_history[back], name)
        )


def test_a_large_bed_is_numbered_by_rows_and_reads_back_in_its_own_numbers(make_scene, monkeypatch):
    from warpdamp.damper.placement import separate
    from warpdamp.engine import arrays as transfer

    cavity = Cylinder(0.034, 0.034)
    scene = make_scene(enclosure=cavity, gravity=(0, 0, -G))
    state = State.at_rest(separate((2e-3,) * 400, cavity, 1), 2e-3)
    state.velocity[:] = np.random.default_rng(1).normal(scale=0.3, size=(400, 3))
    results = []
    for fewest in (10_000, 100):
        monkeypatch.setattr(transfer, "FEWEST_ORDERED", fewest)
        batch = Batch([Case(scene, state, 1e-6)])
        batch.advance(3000)
        results.append(batch.read()[0])
    (plain, ledger), (curved, curved_ledger) = results
    np.testing.assert_allclose(curved.position, plain.position, atol=1e-11)
    assert curved_ledger.dissipated[0] == pytest.approx(ledger.dissipated[0], rel=1e-6)
    ours, theirs = (
        dict(
            zip(
                map(tuple, s.pairs.tolist()),
                np.column_stack([s.pair_history.stretch, s.pair_history.radius]),
                strict=True,
            )
        )
        for s in (plain, curved)
    )
    assert ours.keys() == theirs.keys()
    assert len(ours) > 20
    for pair, history in ours.items():  # stretches point the same way whichever came first on the device
        np.testing.assert_allclose(theirs[pair], history, atol=1e-4 * np.abs(history).max())
