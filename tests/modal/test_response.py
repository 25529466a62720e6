"""Harmonic balance and its continuation against closed forms, and its stability against integrations in time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from warpdamp.modal.harmonic_balance import branches, is_stable

DAMPING, CUBIC = 0.02, 0.05  # of x'' + DAMPING x' + x + CUBIC x^3 = F cos(w t)
FREQUENCY = np.linspace(0.5, 2.0, 200) / (2 * np.pi)
AMPLITUDE = np.geomspace(1e-2, 20, 120)


def oscillator(frequency):
    w = 2 * np.pi * frequency
    return 1 - w**2 + 1j * DAMPING * w


def cubic(frequency, amplitude):
    """Duffing's spring by its first harmonic, 3/4 CUBIC a^2."""
    return 0.75 * CUBIC * amplitude**2 + 0j * frequency


def nothing(frequency, amplitude):
    return np.zeros(np.broadcast(frequency, amplitude).shape, complex)


def duffing_frequencies(force, amplitude):
    """Both w at which the balance gives an amplitude: w^4 + (c^2 - 2 s) w^2 + s^2 - (F / a)^2 = 0, s = 1 + 3/4 a^2."""
    s = 1 + 0.75 * CUBIC * amplitude**2
    half = DAMPING**2 / 2 - s
    square = half**2 - s**2 + (force / amplitude) ** 2
    root = np.sqrt(np.where(square > -1e-9, np.maximum(square, 0), np.nan))  # above the peak there is none
    return np.sqrt(np.maximum(-half - root, 0)), np.sqrt(-half + root)


def test_without_a_damper_it_is_the_linear_response():
    """Exact: 1e-9 is what the corrector leaves."""
    (branch,) = branches(oscillator, nothing, 0.05, FREQUENCY, AMPLITUDE)
    z = oscillator(branch.frequency)
    np.testing.assert_allclose(branch.amplitude, 0.05 / np.abs(z), rtol=1e-9)
    np.testing.assert_allclose(branch.phase, -np.angle(z), atol=1e-12)
    assert branch.stable.all()
    assert not branch.closed
    assert not len(branch.folds)
    assert branch.frequency[[0, -1]] == pytest.approx(FREQUENCY[[0, -1]])


@pytest.mark.parametrize("force", [0.05, 0.2])
def test_duffings_branch_is_the_closed_form(force):
    (branch,) = branches(oscillator, cubic, force, FREQUENCY, AMPLITUDE)
    w = 2 * np.pi * branch.frequency
    both = np.array(duffing_frequencies(force, branch.amplitude))
    # 1e-6: at the peak both solutions meet, and a square root turns rounding into its root
    np.testing.assert_allclose(np.nanmin(np.abs(both - w), axis=0), 0, atol=1e-6)


@pytest.mark.parametrize("force", [0.05, 0.2])
def test_duffings_folds_bound_the_unstable_part(force):
    """The folds are the extremes of w(a) on the closed form's two sides; 1e-3: the spacing of the points there."""
    (branch,) = branches(oscillator, cubic, force, FREQUENCY, AMPLITUDE)
    _, right = duffing_frequencies(force, np.geomspace(0.05, 10, 1_000_000))
    jumps_down = np.nanmax(right[500_000:])  # the end of the upper branch
    jumps_up = right[np.flatnonzero(np.diff(right) > 0)[0]]  # the knee of the lower branch
    found = 2 * np.pi * branch.frequency[branch.folds]
    np.testing.assert_allclose(np.sort(found), np.sort([jumps_up, jumps_down]), rtol=1e-3)
    first, last = np.sort(branch.folds)
    inside = np.zeros(len(branch.frequency), bool)
    inside[first : last + 1] = True
    wrong = np.flatnonzero(branch.stable == inside)
    assert np.min(np.abs(wrong[:, None] - [first, last]), axis=1, initial=0).max(initial=0) <= 1  # but at the folds


@pytest.mark.parametrize("lines", [20, 160])
def test_the_fold_does_not_depend_on_the_grid(lines):
    """The step shortens where the curve turns: 1e-6 of the closed form's fold on the coarsest grid and on a fine one."""
    exact = np.nanmax(duffing_frequencies(0.05, np.linspace(1, 3, 1_000_001))[1])
    grid = np.linspace(0.8, 1.2, lines) / (2 * np.pi), np.geomspace(0.05, 5, lines)
    (branch,) = branches(oscillator, cubic, 0.05, *grid)
    assert 2 * np.pi * branch.frequency[branch.folds].max() == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize(("level", "ends"), [("upper", "upper"), ("middle", "either"), ("lower", "lower")])
def test_stability_is_what_integration_in_time_says(level, ends):
    """Started 3 % off each of three states at one frequency: stable ones draw the motion in, the middle one does not.

    5 %: the third harmonic, which the balance leaves out, is CUBIC a^2 / 32 of the first.
    """
    force, w = 0.05, 1.07
    (branch,) = branches(oscillator, cubic, force, FREQUENCY, AMPLITUDE)
    crossing = np.flatnonzero(np.diff(np.sign(2 * np.pi * branch.frequency - w)))
    order = crossing[np.argsort(branch.amplitude[crossing])]
    k = dict(zip(("lower", "middle", "upper"), order, strict=True))[level]
    assert branch.stable[k] == (level != "middle")
    start = 1.03 * branch.amplitude[k] * np.exp(1j * branch.phase[k])
    periods = 150
    t = np.linspace(0, 2 * np.pi / w * periods, periods * 40 + 1)
    motion = solve_ivp(
        lambda t, y: (y[1], force * np.cos(w * t) - DAMPING * y[1] - y[0] - CUBIC * y[0] ** 3),
        t[[0, -1]],
        (start.real, (1j * w * start).real),
        t_eval=t,
        rtol=1e-7,
        atol=1e-9,
    )
    last = slice(-400, None)
    reached = 2 * abs(np.mean(motion.y[0][last] * np.exp(-1j * w * t[last])))
    amplitudes = {name: branch.amplitude[j] for name, j in zip(("lower", "middle", "upper"), order, strict=True)}
    if ends == "either":
        assert min(abs(reached - amplitudes["lower"]), abs(reached - amplitudes["upper"])) < 0.05 * reached
    else:
        assert reached == pytest.approx(amplitudes[ends], rel=0.05)


def test_dry_friction_gives_den_hartogs_response():
    """Z = 1 - w^2 + 4 j T / (pi a): a = sqrt(F^2 - (4 T / pi)^2) / |1 - w^2|, unbounded at resonance, and stable."""
    friction, force = 0.05, 0.1
    found = branches(
        lambda f: 1 - (2 * np.pi * f) ** 2 + 0j,
        lambda f, a: 4j * friction / (np.pi * a) + 0 * f,
        force,
        FREQUENCY,
        AMPLITUDE,
    )
    assert len(found) == 2  # one on each side of the resonance
    for branch in found:
        expected = np.sqrt(force**2 - (4 * friction / np.pi) ** 2) / np.abs(1 - (2 * np.pi * branch.frequency) ** 2)
        np.testing.assert_allclose(branch.amplitude, expected, rtol=1e-8)
        assert branch.stable.all()


def test_a_force_that_friction_holds_moves_nothing():
    assert not branches(
        lambda f: 1 - (2 * np.pi * f) ** 2 + 0j, lambda f, a: 4j * 0.1 / (np.pi * a) + 0 * f, 0.1, FREQUENCY, AMPLITUDE
    )


def falling_damping(frequency, amplitude):
    """Damping that falls with amplitude and rises again: j c w ((1 - a^2 / 4.5 + a^4 / 60) - 1)."""
    return 0.05j * 2 * np.pi * frequency * (-(amplitude**2) / 4.5 + amplitude**4 / 60)


def test_a_detached_branch_is_found():
    """At resonance a c(a) w = F has three solutions: the lowest tops the main branch, the others bound the island."""

    def structure(frequency):
        w = 2 * np.pi * frequency
        return 1 - w**2 + 0.05j * w

    main, island = branches(structure, falling_damping, 0.04, FREQUENCY, AMPLITUDE)
    assert island.closed
    assert not main.closed
    roots = np.roots([1 / 60, 0, -1 / 4.5, 0, 1, -0.04 / 0.05])  # a (1 - a^2 / 4.5 + a^4 / 60) = F / c at w = 1
    roots = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
    roots = roots[roots > 0]
    assert len(roots) == 3
    # damping moves the extremes off w = 1 by c^2 / 4; half a cell's curvature bounds the rest
    assert main.amplitude.max() == pytest.approx(roots[0], rel=2e-3)
    assert island.amplitude.min() == pytest.approx(roots[1], rel=2e-3)
    assert island.amplitude.max() == pytest.approx(roots[2], rel=2e-3)
    assert not island.stable[np.argmin(island.amplitude)]
    assert island.stable[np.argmax(island.amplitude)]


def test_states_without_folds_may_be_unstable():
    """Van der Pol, x'' - mu (1 - x^2) x' + x, entrained off resonance: stable where a^2 > 2 (classical).

    At 1 - w^2 = 2 mu the product of the eigenvalues is positive at every amplitude; their sum is mu (2 - a^2) / (2 w).
    """
    mu = 0.01
    amplitude = np.array([0.5, 1.0, 1.41, 1.42, 1.5, 2.5])
    stable = is_stable(
        lambda f: 1 - (2 * np.pi * f) ** 2 + 0j,
        lambda f, a: -1j * mu * (1 - a**2 / 4) + 0 * f,
        np.full(amplitude.shape, np.sqrt(1 - 2 * mu) / (2 * np.pi)),
        amplitude,
    )
    np.testing.assert_array_equal(stable, amplitude**2 > 2)
