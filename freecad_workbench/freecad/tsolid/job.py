# SPDX-License-Identifier: LGPL-2.1-or-later
"""What bin/tsolid-freecad has FreeCADCmd do; arguments come through the environment.

FreeCADCmd swallows and opens arguments of its own, returns 0 after an exception and treats Ctrl-C
in its own way; so the launcher gives file descriptors 3 and 4 as our standard output and error,
and takes only the exit codes below as ours. Everything is written into the launcher's stage
directory first, which the launcher removes whatever happens.
"""

import importlib
import os
import shutil
import signal
import sys
import traceback
import zipfile

from . import api, binding, sewing

EXIT_BASE = 40  # 40, 41, 42: our 0, 1, 2; all else is FreeCAD's own end

_OUT, _ERR = 3, 4


MAX_NAMES = 8  # of solids in a message


class Failure(Exception):
    """One sentence for the user."""


class Several(Failure):
    """There is more than one solid where one is needed."""

    def __init__(self, path, names):
        some = ", ".join(names[:MAX_NAMES]) + (", ..." if len(names) > MAX_NAMES else "")
        super().__init__(
            "%s holds %d solids (%s); one is needed: tsolid-freecad assembly takes all, with the "
            "faces that they share" % (path, len(names), some))


def _say(descriptor, text):
    data = (text + "\n").encode("utf-8", "backslashreplace")
    try:
        while data:
            data = data[os.write(descriptor, data) :]
    except OSError:  # nobody listens any more
        pass


class _Progress:
    """Stage and percent on one line, when standard error is a terminal."""

    def __init__(self):
        self.shown = ""
        self.active = os.isatty(_ERR)

    def __call__(self, stage, fraction):
        text = "%s %d %%" % (stage, int(100 * fraction))
        if self.active and text != self.shown:
            os.write(_ERR, ("\r%-*s" % (len(self.shown), text)).encode())
            self.shown = text
        return False

    def clear(self):
        if self.shown:
            os.write(_ERR, ("\r%*s\r" % (len(self.shown), "")).encode())
            self.shown = ""


# ---- reading ---------------------------------------------------------------------------------

SHAPES = {
    ".step": "step",
    ".stp": "step",
    ".brep": "brep",
    ".brp": "brep",
    ".iges": "igs",
    ".igs": "igs",
}


def read_part(path, stage, corners=()):
    """The part in a file as api.Part; raises Failure or TsolidError."""
    name, suffix = os.path.splitext(os.path.basename(path))
    suffix = suffix.lower()
    if suffix == ".tsb":
        return api.Part.read_tsb(path, name)
    notes = []
    if suffix == ".fcstd":
        shape = _shape_of_document(path, stage)
    elif suffix in SHAPES:
        shape, notes = sewing.sewn(shape_of_file(path, stage, SHAPES[suffix]))
    else:
        raise Failure(
            "%s: only STEP, BREP, IGES, FCStd and .tsb files are read, by their endings" % path
        )
    if len(shape.Solids) > 1:
        raise Several(path, ["Solid%d" % (k + 1) for k in range(len(shape.Solids))])
    part = api.Part.of(shape, corners=corners)
    part.name, part.notes = name, notes + part.notes
    return part


def _plain_copy(path, stage, suffix):
    """A copy under a plain name: some readers stumble over blanks and newlines."""
    plain = os.path.join(stage, "input." + suffix)
    try:
        shutil.copyfile(path, plain)
    except OSError as error:
        raise Failure("%s cannot be read: %s" % (path, error.strerror)) from None
    return plain


def shape_of_file(path, stage, suffix):
    import Part

    plain = _plain_copy(path, stage, suffix)
    shape = Part.Shape()
    try:
        shape.read(plain)
    except Exception:  # OCC has no exception of its own for a file that is not what it says
        shape = Part.Shape()
    os.unlink(plain)
    if shape.isNull():
        raise Failure("%s holds no shape: it is damaged, empty or of another kind" % path)
    return shape


def open_document(path, stage):
    """The document of an FCStd file, and the copy that it was opened from."""
    import FreeCAD

    plain = _plain_copy(path, stage, "FCStd")
    if not zipfile.is_zipfile(plain):
        raise Failure("%s is not a FreeCAD document" % path)
    try:
        return FreeCAD.openDocument(plain), plain
    except Exception as error:
        raise Failure("%s cannot be opened: %s" % (path, error)) from None


def _shape_of_document(path, stage):
    import FreeCAD

    document, plain = open_document(path, stage)
    found = [o for o in document.Objects if _is_part(o)]
    if not found:
        raise Failure("%s holds no solid" % path)
    if len(found) > 1:
        raise Several(path, [o.Label for o in found])
    shape = found[0].Shape.copy()
    outer = found[0].getGlobalPlacement() * found[0].Placement.inverse()
    shape.Placement = outer * shape.Placement
    FreeCAD.closeDocument(document.Name)
    os.unlink(plain)
    return shape


def _is_part(obj):
    """A solid of the document that no other solid is made of."""
    if not getattr(getattr(obj, "Shape", None), "Solids", ()):
        return False
    group = getattr(obj, "getParentGeoFeatureGroup", lambda: None)()
    if group is not None and group.isDerivedFrom("PartDesign::Body"):
        return False
    if obj.isDerivedFrom("App::Part") or obj.isDerivedFrom("App::DocumentObjectGroup"):
        return False
    users = (o for o in obj.InList if getattr(getattr(o, "Shape", None), "Solids", ()))
    return not any(not o.isDerivedFrom("App::Part") for o in users)


# ---- writing ---------------------------------------------------------------------------------


def write_outputs(result, stage, name, write_page):
    """All outputs of a build, complete, in the stage directory."""
    make = os.path.join(stage, "new")
    os.mkdir(make)
    result.write(os.path.join(make, name + ".tsolid"))
    result.write_vtu(os.path.join(make, name + ".vtu"))
    result.write_report(os.path.join(make, "report.json"))
    _write_document(result, stage, os.path.join(make, name + ".FCStd"), name)
    write_page(os.path.join(make, "report.html"), result.report, result.solid, name)
    return sorted(os.listdir(make))


def _write_document(result, stage, path, name):
    import FreeCAD

    from . import document

    plain = os.path.join(stage, "output.FCStd")
    made = FreeCAD.newDocument("tsolid")
    source = made.addObject("Part::Feature", "Source")
    source.Label = name + " (faces)"
    source.Shape = result.shape
    obj = document.create(source, made)
    obj.Label = name
    document.set_options(obj, result.options)
    document.store(obj, result)
    made.recompute()
    made.saveAs(plain)
    made.Label = name
    made.save()
    FreeCAD.closeDocument(made.Name)
    _verify_document(plain, result.tsolid)
    os.rename(plain, path)


def _verify_document(path, tsolid):
    """FreeCAD does not always say when a disk is full."""
    try:
        with zipfile.ZipFile(path) as archive:
            whole = archive.testzip() is None
            stored = [archive.read(n) for n in archive.namelist() if n.endswith(".tsolid")]
    except (OSError, zipfile.BadZipFile, EOFError):
        whole, stored = False, []
    if not whole or stored != [tsolid]:
        raise Failure("the FreeCAD document could not be written completely: is the disk full?")


def _page_writer():
    """write_html(path, report, solid, title); asked for before the long work, not after it."""
    try:
        return importlib.import_module(".report_html", __package__).write_html
    except ImportError as error:
        raise Failure("the HTML report needs the Python module %s" % error.name) from None


def _targets(out, name):
    names = [name + s for s in (".FCStd", ".tsolid", ".vtu")]
    return [os.path.join(out, n) for n in names + ["report.json", "report.html"]]


def check_targets(path, out, name):
    """Refuses before any work what could only fail, or do harm, at its end."""
    for target in _targets(out, name):
        if os.path.isdir(target):
            raise Failure("%s is a directory" % target)
        if os.path.exists(target) and os.path.samefile(path, target):
            raise Failure("%s would be overwritten: choose another --out" % target)


def commit(stage, names, out):
    """Moves all outputs to their places, or none. The launcher's signals wait meanwhile."""
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        signal.signal(number, signal.SIG_IGN)
    old = os.path.join(stage, "old")
    os.mkdir(old)
    done = []
    try:
        for name in names:
            target = os.path.join(out, name)
            done.append(name)
            if os.path.lexists(target):
                os.rename(target, os.path.join(old, name))
            os.rename(os.path.join(stage, "new", name), target)
    except OSError:
        for name in done:
            target = os.path.join(out, name)
            if os.path.lexists(os.path.join(old, name)):
                os.replace(os.path.join(old, name), target)
            elif not os.path.lexists(os.path.join(stage, "new", name)):
                os.unlink(target)
        raise


# ---- the job ---------------------------------------------------------------------------------


def _options(text, more=None):
    """key=value pairs whose characters the launcher has checked: api.Options, and a dict of those
    that `more` knows (name: how to read it)."""
    given = dict(pair.split("=", 1) for pair in text.split())
    more = more or {}
    kinds = {"effort": str, "octree": str, "tolerance": float,
             "corners": lambda names: names.split(","),
             "analysis_suitable": {"on": True, "off": False}.__getitem__}
    values = {}
    for key, value in given.items():
        try:
            values[key] = more.get(key, kinds.get(key, int))(value)
        except (ValueError, KeyError):
            raise Failure("--%s has no such value: %s" % (key.replace("_", "-"), value)) from None
    try:
        extra = {key: values.pop(key) for key in list(values) if key in more}
        return api.Options(**values), extra
    except ValueError as error:
        raise Failure(str(error)) from None


def _run_assembly(path, out, stage, options):
    from . import assembly_job

    progress = _Progress()
    options, extra = _options(options, assembly_job.OPTIONS)
    result, names = assembly_job.run(path, out, stage, options, extra, progress)
    progress.clear()
    for name in names:
        if os.path.isdir(os.path.join(out, name)):
            raise Failure("%s is a directory" % os.path.join(out, name))
    commit(stage, names, out)
    _say(_OUT if result.exit_code == 0 else _ERR, result.text())
    for written in names:
        _say(_OUT, api.visible("  wrote %s" % os.path.join(out, written)))
    return result.exit_code


def run(command, path, out, stage, options):
    """One check or build; returns our exit code."""
    binding.load()  # a missing library before anything else
    if not os.path.exists(path):
        raise Failure("%s does not exist" % path)
    if not os.path.isfile(path):
        raise Failure("%s is not a file" % path)
    if command == "assembly":
        return _run_assembly(path, out, stage, options)
    progress = _Progress()
    name = os.path.splitext(os.path.basename(path))[0]
    options, _ = _options(options)
    if command == "build":
        check_targets(path, out, name)
        write_page = _page_writer()
    try:
        part = read_part(path, stage, options.corners)
    except Several:
        if command == "build":
            raise
        return _run_assembly(path, out, stage, "check_only=on")
    except binding.Refused as error:
        result = api.CheckResult(name, error.findings, {})
    else:
        result = (api.build if command == "build" else api.check)(part, options, progress)
    progress.clear()
    if not result.satisfied or command == "check":
        _say(_OUT if result.satisfied else _ERR, result.text())
        return 0 if result.satisfied else 1
    if result.solid is None:
        _say(_ERR, result.text())
        return 1
    names = write_outputs(result, stage, name, write_page)
    commit(stage, names, out)
    _say(_OUT, result.text())
    for written in names:
        _say(_OUT, api.visible("  wrote %s" % os.path.join(out, written)))
    return result.exit_code


def main():
    get = os.environ.__getitem__
    try:
        code = run(
            get("TSOLID_JOB_COMMAND"),
            get("TSOLID_JOB_FILE"),
            os.environ.get("TSOLID_JOB_OUT", ""),
            get("TSOLID_JOB_STAGE"),
            os.environ.get("TSOLID_JOB_OPTIONS", ""),
        )
    except (Failure, binding.LibraryError, binding.TsolidError) as error:
        _say(_ERR, "tsolid-freecad: " + api.visible(str(error)))
        code = 1
    except OSError as error:
        place = error.filename2 or error.filename
        place = ": %s" % place if place else ""
        _say(_ERR, "tsolid-freecad: " + api.visible("%s%s" % (error.strerror, place)))
        code = 1
    except MemoryError:
        _say(_ERR, "tsolid-freecad: out of memory")
        code = 1
    except BaseException:
        _say(_ERR, "tsolid-freecad: a defect of this program:\n" + traceback.format_exc())
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(EXIT_BASE + code)  # FreeCAD's own end may change the code
