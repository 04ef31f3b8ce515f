# SPDX-License-Identifier: LGPL-2.1-or-later
"""Assemblies of FreeCAD: which faces of which parts touch, how far others are apart, clashes.

    import freecad.tsolid as ts
    result = ts.check_assembly(App.ActiveDocument)        # or a list of objects, or a shape
    result.verdict, result.watertight, result.text()

Two ways of looking are put together, contact by contact. FreeCAD's kernel measures any faces, as
they are (contacts.py). The library compares control points of the parts that can become hex blocks,
and so proves which contacts are one and the same surface (assembly.py).
"""

import json

import FreeCAD

from . import api, binding, contacts, members
from .assembly import Assembly
from .binding import Severity

EXACT, SAME, PARTIAL, COINCIDENT, NEAR = KINDS = (
    "exact", "geometric", "partial", "coincident", "near")
WATERTIGHT, GAPS, CLASHES, INCOMPLETE = VERDICTS = ("watertight", "gaps", "clashes", "incomplete")
_OF_KERNEL = {contacts.CONTACT: COINCIDENT, contacts.PARTIAL: COINCIDENT, contacts.NEAR: NEAR}
_CLASH_KINDS = ("overlap", "inside", "twice", "self")


class Interface:
    """Two faces of two parts that touch, or nearly: one row of the report.

    kind: exact (same functions and control points), geometric (after exact refinement), partial
    (one covers a part of the other), coincident (the same within the tolerance, not proved) or
    near. gap: largest distance as FreeCAD's kernel measures it, or the library where the kernel
    has seen nothing; deviation: of control points, None where they were not compared."""

    def __init__(self, parts, faces, kind, gap, point, deviation=None):
        self.parts, self.faces = tuple(parts), tuple(faces)
        self.kind, self.gap, self.point = kind, gap, point
        self.deviation = deviation
        self.by_kernel = False

    @property
    def tight(self):
        return self.kind != NEAR


class Clash:
    """Two parts that share volume (None: not known), that are one in the other, or the same."""

    def __init__(self, parts, kind, point, volume=None):
        self.parts, self.kind, self.point, self.volume = tuple(parts), kind, point, volume


class AssemblyResult:
    """What was found. parts: members.Member; refused: {number of a part: its findings}; report:
    the library's JSON report as a dict with what FreeCAD's kernel measured under "kernel"."""

    def __init__(self, name, parts):
        self.name, self.parts = name, parts
        self.refused = {}
        self.interfaces, self.clashes, self.free = [], [], []
        self.findings = []
        self.report = {}

    @property
    def verdict(self):
        if self.clashes:
            return CLASHES
        return WATERTIGHT if all(i.tight for i in self.interfaces) else GAPS

    @property
    def watertight(self):
        return self.verdict == WATERTIGHT

    satisfied = watertight  # as results of other checks call it

    @property
    def exit_code(self):
        return 0 if self.watertight else 2

    @property
    def gap(self):
        """The largest gap of all contacts."""
        return max((i.gap for i in self.interfaces), default=0.0)

    def where(self, row):
        """"Shaft Face3, Blade Face1" of an Interface, "Shaft, Blade" of a Clash."""
        names = [self.parts[p].name for p in row.parts]
        faces = getattr(row, "faces", None)
        if faces is None:
            return ", ".join(dict.fromkeys(names))
        return ", ".join("%s %s" % pair for pair in zip(names, faces))

    def headline(self, tr=lambda text: text):
        if self.verdict == CLASHES:
            return tr("Parts penetrate each other: %d clashes.") % len(self.clashes)
        if self.verdict == GAPS:
            return tr("Not watertight: gaps of up to %.6g.") % self.gap
        if not self.interfaces:
            return tr("No parts touch.")
        proved = sum(1 for i in self.interfaces if i.kind in (EXACT, SAME, PARTIAL))
        return tr("Watertight: %d contacts, %d of them proved to be one surface.") % (
            len(self.interfaces), proved)

    def text(self):
        lines = ["%s: %s" % (self.name, self.headline())]
        lines.append("  %d parts, %d contacts, %d clashes, %d free faces" % (
            len(self.parts), len(self.interfaces), len(self.clashes), len(self.free)))
        for c in self.clashes:
            lines.append("  clash (%s): %s%s" % (c.kind, self.where(c), _at(c)))
        for i in self.interfaces:
            lines.append("  %s: %s, gap %.3g%s" % (i.kind, self.where(i), i.gap,
                                                   "" if i.tight else _at(i)))
        for k, findings in sorted(self.refused.items()):
            text = "  %s cannot become hex blocks: %s" % (self.parts[k].name, findings[0])
            lines.append(text)
        return "\n".join(api.visible(line) for line in lines)

    def as_dict(self):
        return self.report


def _at(row):
    if row.point is None:
        return ""
    volume = getattr(row, "volume", None)
    words = ", %.6g of volume" % volume if volume else ""
    return "%s near (%.6g, %.6g, %.6g)" % ((words,) + tuple(row.point))


# ---- what comes in -------------------------------------------------------------------------------


def parts_of(given):
    """Members of a document, an object, a list of objects, or a shape."""
    if hasattr(given, "Objects") and hasattr(given, "addObject"):
        return members.of_document(given)
    if hasattr(given, "Document"):
        return members.of_objects([given])
    if hasattr(given, "Solids"):
        return members.of_shape(given)
    return members.of_objects(list(given))


def _patches(part):
    """The part's patches in its own frame (without the placement it shares with no copy)."""
    shape = part.shape.copy()
    shape.Placement = FreeCAD.Placement()
    return api.Part.of(shape)


def _matrix(placement):
    m = placement.toMatrix()
    return (m.A11, m.A12, m.A13, m.A14, m.A21, m.A22, m.A23, m.A24, m.A31, m.A32, m.A33, m.A34)


class AssemblyJob:
    """One check of document objects, to be run in any thread; compare actions.Job."""

    kind = "assembly"

    def __init__(self, objects, gap=None):
        self.objects, self.options = list(objects), gap
        if not self.objects:
            raise ValueError("the document is empty")
        self.given = self.objects[0]
        self.parts = parts_of(self.objects)
        self.result = None

    def fits(self, kind, given, options):
        return (kind == self.kind and self.options == options
                and [o.Name for o in self.objects] == [o.Name for o in given])

    def run(self, progress=None):
        if self.result is None:
            name = self.given.Document.Label
            self.result = check_parts(self.parts, self.options, progress=progress, name=name)
        return self


def check_objects(objects, gap=None, progress=None):
    """The check of document objects; takes what a job has made ready."""
    from . import actions

    found = actions.ready_result("assembly", objects, gap)
    return AssemblyJob(objects, gap).run(progress).result if found is None else found


# ---- the check -----------------------------------------------------------------------------------


def check(given, gap=None, tolerance=0.0, progress=None, name="Assembly"):
    """Contacts, gaps and clashes of the parts as they are; nothing is built. Works on any solids.

    given: a document, objects, or a shape. gap: how far apart faces may be to be near contacts;
    None: a hundredth of the smaller part.
    """
    return check_parts(parts_of(given), gap, tolerance, progress, name)


def check_parts(parts, gap=None, tolerance=0.0, progress=None, name="Assembly"):
    """The same of members.Member."""
    if len(parts) < 2:
        raise ValueError("an assembly has two parts or more: %d found" % len(parts))
    result = AssemblyResult(name, parts)

    def tell(stage):
        def step(fraction):
            if progress is not None and progress(stage, fraction):
                raise binding.Cancelled(binding.Status.ERROR_CANCELLED, [])
        return step

    taken = _take(result, tell("shape"))
    context = binding.Context(progress)
    sources = [taken[p.first].patches if p.first in taken else [] for p in parts]
    copies = {}  # one list for all copies: that is how the library knows them
    for k, part in enumerate(parts):
        sources[k] = copies.setdefault(part.first, sources[k])
    rows = [(p.name, s, _matrix(p.placement)) for p, s in zip(parts, sources)]
    found = Assembly.create(context, rows, tolerance, gap or 0.0)
    kernel = contacts.find([p.shape for p in parts], gap, tell("kernel"))
    result.report = json.loads(found.json(context))
    result.findings += context.findings()
    _merge(result, found, kernel, taken)
    result.report["kernel"] = _kernel_dict(result, kernel)
    result.report["verdict"] = result.verdict
    return result


def _take(result, tell):
    """{number of a first part: api.Part} of the geometries that can become hex blocks."""
    taken = {}
    firsts = sorted({p.first for p in result.parts})
    for n, k in enumerate(firsts):
        tell(n / len(firsts))
        try:
            taken[k] = _patches(result.parts[k])
        except binding.Refused as error:
            for m, part in enumerate(result.parts):
                if part.first == k:
                    result.refused[m] = [f for f in error.findings if f.severity == Severity.ERROR]
    return taken


def _merge(result, found, kernel, taken):
    rows = {}
    for i in found.interfaces:
        faces = [_face_name(taken, result.parts[p], k) for p, k in zip(i["part"], i["patch"])]
        key = _key(i["part"], faces)
        row = Interface(*key, KINDS[i["kind"]], i["gap"], i["point"], i["deviation"])
        rows[key] = row if key not in rows else _worse(rows[key], row)
    for contact in kernel:
        if contact.kind == contacts.CLASH:
            result.clashes.append(Clash(contact.members, _CLASH_KINDS[0], contact.place,
                                        contact.volume))
            continue
        key = _key(contact.members, ["Face%d" % (f + 1) for f in contact.faces])
        row = rows.setdefault(key, Interface(*key, _OF_KERNEL[contact.kind], 0.0, None))
        row.gap, row.point, row.by_kernel = contact.gap, contact.place, True
    result.interfaces = [rows[key] for key in sorted(rows)]
    known = {tuple(sorted(c.parts)) for c in result.clashes}
    for c in found.clashes:
        parts = [p for p in c["part"] if p >= 0]
        if tuple(sorted(parts)) in known:
            same = next(k for k in result.clashes if sorted(k.parts) == sorted(parts))
            same.kind = _CLASH_KINDS[c["kind"]]
        else:
            result.clashes.append(Clash(parts, _CLASH_KINDS[c["kind"]], c["point"]))
    clashing = {tuple(sorted(c.parts)) for c in result.clashes}
    result.interfaces = [i for i in result.interfaces if tuple(sorted(i.parts)) not in clashing]
    result.free = _free_faces(result)


def _key(parts, faces):
    pairs = sorted(zip(parts, faces))
    return tuple(p for p, _ in pairs), tuple(f for _, f in pairs)


def _face_name(taken, part, k):
    return taken[part.first].patches[k].name


def _worse(a, b):
    """Of two pieces of the same pair of faces: the weaker kind, the larger numbers."""
    out = max((a, b), key=lambda row: KINDS.index(row.kind))
    out.gap = max(a.gap, b.gap)
    return out


def _free_faces(result):
    """(part, face) of every face without a contact."""
    touched = {(p, f) for i in result.interfaces for p, f in zip(i.parts, i.faces)}
    return [(k, "Face%d" % (n + 1)) for k, part in enumerate(result.parts)
            for n in range(len(part.shape.Faces)) if (k, "Face%d" % (n + 1)) not in touched]


def _kernel_dict(result, kernel):
    out = {"contacts": [], "clashes": []}
    for c in kernel:
        row = {"parts": [result.parts[p].name for p in c.members], "point": list(c.place)}
        if c.kind == contacts.CLASH:
            out["clashes"].append(dict(row, volume=c.volume))
            continue
        row.update(faces=["Face%d" % (f + 1) for f in c.faces], kind=c.kind, gap=c.gap,
                   smallest_gap=c.least, covered=list(c.covered))
        out["contacts"].append(row)
    return out
