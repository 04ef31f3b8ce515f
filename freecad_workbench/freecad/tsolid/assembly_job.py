# SPDX-License-Identifier: LGPL-2.1-or-later
"""What `tsolid-freecad assembly` has FreeCADCmd do; called by job.py."""

import os

from . import assemblies, files, job, members, sewing

OPTIONS = {"gap": float, "check_only": {"on": True}.__getitem__}


def read_parts(path, stage):
    """The solids of a file as members.Member, and notes on how they were made of loose faces;
    raises job.Failure."""
    name, suffix = os.path.splitext(os.path.basename(path))
    suffix = suffix.lower()
    if suffix == ".fcstd":
        return _parts_of_document(path, stage), []
    if suffix in job.SHAPES:
        shape, notes = sewing.sewn(job.shape_of_file(path, stage, job.SHAPES[suffix]))
        return members.of_shape(shape), notes
    raise job.Failure(
        "%s: assemblies are read from STEP, BREP, IGES and FCStd files, by their endings; for .tsb "
        "files there is the command tsolid assembly" % path)


def _parts_of_document(path, stage):
    """Shapes outlive their document."""
    import FreeCAD

    document, plain = job.open_document(path, stage)
    parts = members.of_document(document)
    for part in parts:
        part.obj = None
    FreeCAD.closeDocument(document.Name)
    os.unlink(plain)
    return parts


def run(path, out, stage, options, extra, progress):
    """Checks, and builds unless only the check is wanted; returns (result, names of the files
    written into the stage directory)."""
    parts, notes = read_parts(path, stage)
    if len(parts) < 2:
        raise job.Failure("%s holds %d solid%s; an assembly has two or more"
                          % (path, len(parts), "" if len(parts) == 1 else "s"))
    name = os.path.splitext(os.path.basename(path))[0]
    if extra.get("check_only"):
        given = (parts, extra.get("gap"), options.tolerance, progress, name)
        return _noted(assemblies.check_parts(*given), notes), []
    job.check_targets(path, out, name)
    result = assemblies.build_parts(parts, options, extra.get("gap"), progress, name)
    _noted(result, notes)
    return result, _write(result, stage, name)


def _noted(result, notes):
    result.notes += notes
    return result


def _write(result, stage, name):
    """All outputs, complete, in the stage directory."""
    make = os.path.join(stage, "new")
    os.mkdir(make)
    for k, own in _file_names(result).items():
        result.built[k].write(os.path.join(make, own + ".tsolid"))
    files.write_check(result, os.path.join(make, "report.json"))
    files.write_check(result, os.path.join(make, "report.html"))
    plain = os.path.join(stage, "output.FCStd")
    _write_document(result, plain, name)
    os.rename(plain, os.path.join(make, name + ".FCStd"))
    return sorted(os.listdir(make))


def _file_names(result):
    """{number of a built part: a file name of its own}, whatever the part is called."""
    names, out = set(), {}
    for k, built in sorted(result.built.items()):
        if built.solid is None:
            continue
        plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in result.parts[k].name)
        own = plain.lstrip(".")[:80] or "part"
        while own.lower() in names:
            own += "_"
        names.add(own.lower())
        out[k] = own
    return out


def _write_document(result, path, name):
    """One object per part that was built, copies as Links to it; the faces beside them."""
    import FreeCAD

    from . import document

    made = FreeCAD.newDocument("tsolid")
    objects = {}
    for k, built in sorted(result.built.items()):
        if built.solid is None:
            continue
        source = made.addObject("Part::Feature", "Source")
        source.Label = result.parts[k].name + " (faces)"
        source.Shape = built.shape
        obj = document.create(source, made)
        obj.Label = result.parts[k].name
        document.set_options(obj, built.options)
        document.store(obj, built)
        objects[k] = obj
    for k, part in enumerate(result.parts):
        if part.first not in objects:
            continue
        placement = result.frames[k]
        if k == part.first:
            objects[k].Placement = placement.multiply(objects[k].Placement)
            continue
        link = made.addObject("App::Link", "Copy")
        link.LinkedObject = objects[part.first]
        link.LinkTransform = False
        link.Placement = placement
        link.Label = part.name
    made.recompute()
    made.saveAs(path)
    made.Label = name
    made.save()
    FreeCAD.closeDocument(made.Name)
