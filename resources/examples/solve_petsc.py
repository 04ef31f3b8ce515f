#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Solves elasticity or heat conduction on a solid with PETSc, on one process or on many.

    tsolid export part.tsolid --matrices part --format petsc --young 210e3 --poisson 0.3
    mpirun -n 8 python3 solve_petsc.py part --fixed x_low --load x_high 0 0 -5 \\
        --out displacement.petsc --solid part.tsolid --vtu part.vtu

--fixed FACE      nothing moves there (laplace: the temperature is 0); any number of times
--load FACE T...  traction in x, y, z, force per area (laplace: heat flux, one number)
--kind            elasticity (default) or laplace
--solid, --vtu    the result on the solid, by the command tsolid (TSOLID_COMMAND tells where it is)

Everything else goes to PETSc, e.g. -ksp_type minres -pc_type hypre -ksp_monitor. The default is
conjugate gradients with smoothed aggregation, which is told the rigid motions: the control points
are the coefficients of the functions x, y and z. Debian's petsc4py without PETSc's development
files is found with PETSC_DIR=/usr/lib/petscdir/petsc3.18/x86_64-linux-gnu-real.
"""

import argparse
import json
import os
import subprocess
import sys

import petsc4py

arguments = argparse.ArgumentParser(usage=__doc__)
arguments.add_argument("folder")
arguments.add_argument("--kind", choices=("elasticity", "laplace"), default="elasticity")
arguments.add_argument("--fixed", action="append", default=[])
arguments.add_argument("--load", action="append", nargs="+", default=[])
arguments.add_argument("--out", required=True)
arguments.add_argument("--solid")
arguments.add_argument("--vtu")
options, rest = arguments.parse_known_args()
petsc4py.init([sys.argv[0]] + rest)
from petsc4py import PETSc  # noqa: E402  (after its own options)


def path(name):
    return os.path.join(options.folder, name)


def binary(name, mode="r"):
    return PETSc.Viewer().createBinary(name, mode)


def petsc_file(names):
    names = [n for n in names if n.endswith(".petsc")]
    if not names:
        sys.exit("%s holds no PETSc files: export with --format petsc" % options.folder)
    return path(names[0])


def load_matrix(index, width):
    if options.kind not in index["matrices"]:
        sys.exit("%s holds no %s matrix" % (options.folder, options.kind))
    matrix = PETSc.Mat().create()
    matrix.setBlockSize(width)
    matrix.setType(PETSc.Mat.Type.AIJ)
    matrix.load(binary(petsc_file(index["matrices"][options.kind]["files"])))
    return matrix


def load_vector(name, n_local, width):
    vector = PETSc.Vec().create()
    vector.setSizes((n_local, PETSc.DETERMINE), bsize=width)
    vector.setFromOptions()
    vector.load(binary(name))
    return vector


def right_hand_side(index, matrix, width):
    """Sum of tractions times loads; function A has the rows width A + i, on the same process."""
    right = matrix.createVecLeft()
    faces = {face["name"]: face for face in index["faces"]}
    n_local = matrix.getLocalSize()[0] // width
    for name, *traction in options.load:
        if name not in faces or len(traction) != width:
            sys.exit("--load takes one of %s and %d numbers" % (", ".join(faces), width))
        share = load_vector(petsc_file(faces[name]["load"]), n_local, 1)
        for i, value in enumerate(traction):
            right.array[i::width] += float(value) * share.array
    return right


def fixed_rows(index, matrix, width):
    """The rows of the Dirichlet sets that this process owns."""
    faces = {face["name"]: face for face in index["faces"]}
    unknown = [name for name in options.fixed if name not in faces]
    if unknown or not options.fixed:
        sys.exit("--fixed takes one of %s" % ", ".join(faces))
    functions = sorted({f for name in options.fixed for f in faces[name]["functions"]})
    first, end = matrix.getOwnershipRange()
    rows = [width * f + i for f in functions for i in range(width)]
    return [row for row in rows if first <= row < end]


def solve(matrix, right):
    solver = PETSc.KSP().create()
    solver.setOperators(matrix)
    solver.setType(PETSc.KSP.Type.CG)
    solver.getPC().setType(PETSc.PC.Type.GAMG)
    solver.setTolerances(rtol=1e-12, max_it=2000)
    solver.setFromOptions()
    solution = matrix.createVecRight()
    solver.solve(right, solution)
    if solver.getConvergedReason() <= 0:
        sys.exit("no convergence: PETSc's reason %d" % solver.getConvergedReason())
    PETSc.Sys.Print(
        "%d unknowns, %d processes, %d iterations, residual %.3g"
        % (right.getSize(), right.comm.size, solver.getIterationNumber(), solver.getResidualNorm())
    )
    return solution


def main():
    with open(path("index.json"), encoding="utf-8") as stream:
        index = json.load(stream)
    width = 3 if options.kind == "elasticity" else 1
    matrix = load_matrix(index, width)
    right = right_hand_side(index, matrix, width)
    rows = fixed_rows(index, matrix, width)
    matrix.zeroRowsColumns(rows)
    right.setValues(rows, [0.0] * len(rows))
    right.assemble()
    if width == 3:
        points = load_vector(path(index["points"]), matrix.getLocalSize()[0], 3)
        matrix.setNearNullSpace(PETSc.NullSpace().createRigidBody(points))
    solution = solve(matrix, right)
    solution.view(binary(options.out, "w"))
    if options.vtu and right.comm.rank == 0:
        name = "displacement" if width == 3 else "temperature"
        command = os.environ.get("TSOLID_COMMAND", "tsolid")
        words = [command, "export", options.solid, "--vtu", options.vtu]
        subprocess.run(words + ["--field", "%s=%s" % (name, options.out)], check=True)


main()
