"""YADE: a bed of spheres in a cylinder that is shaken along its axis, seen from the laboratory.

    yade -x -n -j1 yade.py        in a folder with scene.in and bed.data (scripts/benchmarks/peers.py writes them)

Floor and lid are walls, the side is made of flat facets outside the cylinder; all move, and the spheres start with the
speed that the enclosure has at the first step.  Hertz-Mindlin contacts with dashpots after Tsuji, which may pull.

Writes cpu.txt, the processor time [ns] before and after the shaking, and, unless the run is lean, power.txt: the mean
power that YADE's own tally says is dissipated in each cycle [W].
"""

import math
import time

from yade import O, geom
from yade.utils import sphere, wall
from yade.wrapper import (
    Bo1_Facet_Aabb,
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    FrictMat,
    HarmonicMotionEngine,
    Ig2_Facet_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom_MindlinPhys_Mindlin,
    NewtonIntegrator,
    Sphere,
)

SIDES = 64
"""Facets round the cylinder: the gap behind them is 0.1 % of the radius."""

with open("scene.in") as file:
    scene = {name: float(value) for _, name, _, value in map(str.split, file)}
with open("bed.data") as file:
    lines = file.read().partition("Atoms")[2].split("\n")
spheres = [[float(value) for value in line.split()] for line in lines if line.strip()]

radius, height = scene["radius"], scene["height"]
density = spheres[0][3]
material = O.materials.append(
    FrictMat(
        young=scene["youngs_modulus"],
        poisson=scene["poissons_ratio"],
        density=density,
        frictionAngle=math.atan(scene["friction"]),
    )
)
for _, _, diameter, _, x, y, z in spheres:
    O.bodies.append(sphere((x, y, z), diameter / 2, material=material))
side = geom.facetCylinder(
    (0, 0, height / 2),
    radius / math.cos(math.pi / SIDES),
    1.1 * height,
    segmentsNumber=SIDES,
    wallMask=4,
    material=material,
)
ends = [wall(0, axis=2, sense=1, material=material), wall(height, axis=2, sense=-1, material=material)]
enclosure = O.bodies.append(side + ends)

speed = 2 * math.pi * scene["frequency"]
displacement = scene["acceleration"] / speed**2
for body in O.bodies:
    if isinstance(body.shape, Sphere):
        body.state.vel = (0, 0, displacement * speed)

counted = scene["every"] == 1
law = Law2_ScGeom_MindlinPhys_Mindlin(calcEnergy=counted)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()], verletDist=scene["skin"]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(en=scene["restitution"])],
        [law],
    ),
    HarmonicMotionEngine(A=(0, 0, -displacement), f=(0, 0, scene["frequency"]), fi=(0, 0, math.pi / 2), ids=enclosure),
    NewtonIntegrator(gravity=(0, 0, -scene["gravity"]), damping=0),
]
O.dt = scene["dt"]


def dissipated():
    """By all channels of YADE's tally so far [J]."""
    return law.normDampDissip + law.shearDampDissip + law.frictionDissipation


cycle, steps = int(scene["cycle"]), int(scene["steps"])
power, spent, before = [], 0, 0.0
O.run(1, True)  # finds the first neighbours
started = time.process_time_ns()
for last in [*range(cycle, steps, cycle), steps]:
    O.run(last - O.iter, True)
    if counted and last % cycle == 0:
        now = dissipated()
        power.append((last, (now - before) * scene["frequency"]))
        before = now
ended = time.process_time_ns()

with open("cpu.txt", "w") as file:
    file.write(f"{started}\n{ended}\n")
if counted:
    with open("power.txt", "w") as file:
        file.writelines(f"{step} {value!r}\n" for step, value in power)
