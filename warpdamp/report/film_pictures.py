"""Film as pictures: gif by Pillow, mp4 by ffmpeg."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import MissingLibrary, SimulationError
from ..files import whole_file
from ..scene.shape import bodies_of
from .film import QUANTITIES, Film
from .film_page import COLOURMAP

TURN, TILT = 0.6, 0.25
"""Direction of view: turned about the axis of the cavity, and from above [rad]."""

WIDTH, HEIGHT, DPI = 7.2, 4.32, 100
SCENE = 3.8
"""Width of a cavity's part of the picture [inches]; every damper beside the first makes it as much wider."""
RATE = 20
"""Frames shown a second."""

CORNERS = 48
"""Corners of a particle's outline."""

GIF_COLOURS = 128
LARGEST_LINE = 3.0
"""Width of the strongest contact force's line [points]."""


def write_gif(film: Film, path: Path) -> None:
    """Write a film as a gif that repeats."""
    from PIL import Image

    shots = list(pictures(film))
    some = np.concatenate(shots[:: max(1, len(shots) // 4)])
    palette = Image.fromarray(some).quantize(GIF_COLOURS, dither=Image.Dither.NONE)
    images = [Image.fromarray(shot).quantize(palette=palette, dither=Image.Dither.NONE) for shot in shots]
    with whole_file(path) as part:
        images[0].save(
            part, format="gif", save_all=True, append_images=images[1:], duration=1000 // RATE, loop=0, optimize=True
        )


def write_mp4(film: Film, path: Path) -> None:
    """Write a film as mp4 (H.264).

    Raises
    ------
    MissingLibrary
        If imageio-ffmpeg is not installed.
    """
    try:
        from imageio_ffmpeg import write_frames
    except ImportError:
        line = "films as mp4 need imageio-ffmpeg: pip install 'warpdamp[film]'"
        raise MissingLibrary(line, name="imageio_ffmpeg") from None
    size = round(_width(film) * DPI), round(HEIGHT * DPI)
    with whole_file(path) as part:
        # one after the other, or the order in which threads end would change the bits
        writer = write_frames(str(part), size, fps=RATE, codec="libx264", output_params=["-threads", "1", "-bitexact"])
        writer.send(None)
        try:
            for picture in pictures(film):
                writer.send(np.ascontiguousarray(picture))
        finally:
            writer.close()
        if not part.stat().st_size:
            raise SimulationError(f"{path}: ffmpeg wrote nothing")


def pictures(film: Film) -> Iterator[np.ndarray]:
    """Pictures of the frames, (height, width, 3) arrays of bytes: the cavity, and the course of the case beside it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure, change = _figure(film)
    canvas = FigureCanvasAgg(figure)
    for k in range(len(film.frames)):
        change(k)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _figure(film: Film):
    """Figure of a film, and the function that changes it to a frame."""
    from matplotlib.figure import Figure

    width = _width(film)
    figure = Figure(figsize=(width, HEIGHT), dpi=DPI)

    def place(left: float, bottom: float, wide: float, high: float):
        """Axes by inches from the left, and parts of the height."""
        return figure.add_axes((left / width, bottom, wide / width, high))

    scenes = [place(0.07 + SCENE * k, 0.14, SCENE, 0.74) for k in range(len(film.every))]
    bar = place(0.36, 0.115, 3.24, 0.025)
    right = width - WIDTH
    phase, course = place(right + 4.75, 0.62, 2.23, 0.22), place(right + 4.75, 0.115, 2.23, 0.34)
    figure.text(0.144 / width, 0.95, film.title, fontsize=11, weight="bold", va="center")
    for k, one in enumerate(film.every):
        figure.text((0.144 + SCENE * k) / width, 0.905, one.label, fontsize=9, va="center")
    mappable, reach = _colour_scale(film), max(map(_reach, film.every))
    draw_scenes = [_scene(ax, one, film, mappable, reach) for ax, one in zip(scenes, film.every, strict=True)]
    quantity = QUANTITIES[film.colour]
    figure.colorbar(mappable, cax=bar, orientation="horizontal")
    bar.set_xlabel(f"{quantity.name} [{quantity.unit}]", fontsize=8, labelpad=1)
    bar.tick_params(labelsize=7)
    changes = (*draw_scenes, _phase(phase, film), _course(course, film))

    def change(k: int) -> None:
        for part in changes:
            part(k)

    return figure, change


def _view() -> np.ndarray:
    """Directions to the right, up and towards the viewer, (3, 3) rows."""
    ct, st, ce, se = np.cos(TURN), np.sin(TURN), np.cos(TILT), np.sin(TILT)
    return np.array([[ct, st, 0], [-st * se, ct * se, ce], [st * ce, -ct * ce, se]])


def _width(film: Film) -> float:
    """Width of a picture [inches]."""
    return WIDTH + SCENE * len(film.beside)


def _colour_scale(film: Film):
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    return ScalarMappable(Normalize(0, film.most(film.colour)), colormaps[COLOURMAP])


def _reach(film: Film) -> float:
    """Largest distance of the cavity's edge from its middle at rest [m]."""
    cavity, sway = film.trajectory.scene.enclosure, film.trajectory.displacement
    return float(np.hypot(cavity.diameter / 2, cavity.height / 2) + np.linalg.norm(sway, axis=1).max())


def _scene(ax, film: Film, scale: Film, mappable, reach: float):
    """Function that draws a frame of a film, in the colours and the size that all films beside it share."""
    from matplotlib.collections import LineCollection, PolyCollection

    view, cavity = _view(), film.trajectory.scene.enclosure
    values, sway = film.values(scale.colour), film.trajectory.displacement
    middle = np.array([0, 0, cavity.height / 2])
    ax.set(xlim=(-reach, reach), ylim=(-reach * 1.08, reach), aspect="equal")
    ax.axis("off")

    def seen(points):
        return (np.asarray(points) - middle) @ view.T

    def draw(k: int) -> None:
        for artist in [*ax.collections, *ax.lines]:
            artist.remove()
        frame, shift = film.frames[k], sway[k]
        behind, before = _outline(cavity, shift)
        for line in behind:
            ax.plot(*seen(line)[:, :2].T, color="#8b97a4", lw=1, zorder=1)
        at = seen(frame.state.position + shift)
        order = np.argsort(at[:, 2])
        outlines = at[:, None, :2] + _outlines(frame, view)
        colours = mappable.to_rgba(values[k])
        colours[:, 3] = 0.35 if scale.forces else 1.0
        ax.add_collection(
            PolyCollection(
                outlines[order],
                facecolors=colours[order],
                edgecolors="#1d2733",
                linewidths=0.5,
                zorder=2,
            )
        )
        if scale.forces:
            lines, size = _force_lines(frame, shift, cavity)
            strong = LARGEST_LINE * np.sqrt(size / scale.strongest)
            flat = [seen(line)[:, :2] for line in lines]
            ax.add_collection(LineCollection(flat, linewidths=strong, colors="#8b1a1a", capstyle="round", zorder=3))
        for line in before:
            ax.plot(*seen(line)[:, :2].T, color="#8b97a4", lw=1, zorder=4)

    return draw


def _outlines(frame, view: np.ndarray) -> np.ndarray:
    """Outlines of the particles about their centres, (n, CORNERS, 2) [m], for they are convex."""
    bodies, angle = bodies_of(frame.state), np.linspace(0, 2 * np.pi, CORNERS, endpoint=False)
    towards = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ view[:2]
    corners = [bodies.point(np.broadcast_to(direction, bodies.axis.shape)) for direction in towards]
    return np.stack(corners, axis=1) @ view[:2].T


def _outline(cavity, shift: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Lines of the cavity behind the particles and before them."""
    round_ = np.linspace(0, 2 * np.pi, 73)
    radius, height = cavity.diameter / 2, cavity.height
    ring = np.stack([radius * np.cos(round_), radius * np.sin(round_), 0 * round_], axis=1) + shift
    behind = [ring] if cavity.floor or cavity.side else []
    if cavity.side:
        edge = radius * np.array([np.cos(TURN), np.sin(TURN), 0])
        behind += [np.array([sign * edge, sign * edge + [0, 0, height]]) + shift for sign in (-1, 1)]
    return behind, [ring + [0, 0, height]] if cavity.lid or cavity.side else []


def _force_lines(frame, shift: np.ndarray, cavity) -> tuple[np.ndarray, np.ndarray]:
    """Lines between what presses on each other, (m, 2, 3) [m], and their forces [N]."""
    x, pairs = frame.state.position, frame.touching.pairs
    first, wall = x[pairs[:, 0]], -1 - pairs[:, 1]
    side = first.copy()
    rho = np.maximum(np.linalg.norm(first[:, :2], axis=1), 1e-300)
    side[:, :2] *= (cavity.diameter / 2 / rho)[:, None]
    floor, lid = first * [1, 1, 0], first * [1, 1, 0] + [0, 0, cavity.height]
    at_wall = np.choose(np.maximum(wall, 0)[:, None], [side, floor, lid])
    second = np.where((wall >= 0)[:, None], at_wall, x[pairs[:, 1]])
    return np.stack([first, second], axis=1) + shift, np.linalg.norm(frame.touching.force, axis=1)


COLOURS = ("#1b6ca8", "#2e7d32", "#7b3fa0", "#806000")
"""Colours of the dampers' lines, one after the other."""


def _lines(film: Film) -> list[tuple[Film, str]]:
    return [(one, COLOURS[k % len(COLOURS)]) for k, one in enumerate(film.every)]


def _phase(ax, film: Film):
    degrees, dots = np.linspace(0, 360, 121), []
    for one, colour in _lines(film):
        amplitude = 1e3 * one.trajectory.scene.drive.displacement
        apart = one.frames[0].cycle - film.frames[0].cycle
        ax.plot(degrees, amplitude * np.sin(np.radians(degrees) + 2 * np.pi * apart), color=colour, lw=1.2)
        dots.append(ax.plot([], [], "o", color="#c8410b", ms=6)[0])
    ax.set_xticks([0, 90, 180, 270, 360])
    ax.tick_params(labelsize=7)
    ax.set_xlabel("phase of the drive [°]", fontsize=8, labelpad=1)
    ax.set_ylabel("[mm]", fontsize=8)
    ax.grid(alpha=0.3)
    direction = np.asarray(film.trajectory.scene.drive.direction)

    def draw(k: int) -> None:
        at = 360 * (film.frames[k].cycle % 1)
        for dot, one in zip(dots, film.every, strict=True):
            dot.set_data([at], [1e3 * float(one.trajectory.displacement[k] @ direction)])
        ax.set_title(f"cycle {film.frames[k].cycle:.2f}", fontsize=9)

    return draw


def _course(ax, film: Film):
    for k, (one, colour) in enumerate(_lines(film), 1):
        effectiveness = one.trajectory.effectiveness
        cycle = np.arange(1, len(effectiveness) + 1)
        ax.plot(cycle, effectiveness, "o-", ms=3, lw=1, color=colour, label=f"damper {k}")
        ax.plot(cycle[: one.discarded], effectiveness[: one.discarded], "o", ms=2, color="white")
    rule = ax.axvline(1, color="#c8410b", lw=1)
    most = max(float(np.max(one.trajectory.effectiveness)) for one in film.every)
    ax.set_ylim(0, 1.1 * max(most, 1e-12))
    if film.beside:
        ax.legend(fontsize=7)
    ax.tick_params(labelsize=7)
    ax.set_xlabel("cycle", fontsize=8, labelpad=1)
    ax.set_ylabel("effectiveness [-]", fontsize=8)
    ax.grid(alpha=0.3)

    def draw(k: int) -> None:
        now = min(len(film.trajectory.effectiveness), int(film.frames[k].cycle) + 1)
        rule.set_xdata([now, now])

    return draw
