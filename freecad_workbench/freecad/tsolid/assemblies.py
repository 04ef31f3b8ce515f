# SPDX-License-Identifier: LGPL-2.1-or-later
"""Assemblies of FreeCAD: which faces of which parts touch, how far others are apart, clashes.

    import freecad.tsolid as ts
    result = ts.check_assembly(App.ActiveDocument)        # or a list of objects, or a shape
    result.verdict, result.watertight, result.text()
    result = ts.build_assembly(App.ActiveDocument)        # solids that share what is at contacts
    result.built[0].report, result.interfaces[0].gap_after

Two ways of looking are put together, contact by contact. FreeCAD's kernel measures any faces, as
they are (contacts.py). The library compares control points of the parts that can become hex blocks,
and so proves which contacts are one and the same surface (assembly.py).
"""

import collections
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
    has seen nothing; deviation: of control points, None where they were not compared. After a
    build, None where it is not known: same_functions, same_bits (control points agree bit for bit),
    gap_after (largest distance of both solids' own points), ulp_after (the same in units of the
    last place) and continuity (least order of the functions across the contact's border where that
    lies inside a face; -1: nowhere)."""

    def __init__(self, parts, faces, kind, gap, point, deviation=None):
        self.parts, self.faces = tuple(parts), tuple(faces)
        self.kind, self.gap, self.point = kind, gap, point
        self.deviation = deviation
        self.same_functions = self.same_bits = self.gap_after = self.ulp_after = None
        self.continuity = None

    @property
    def tight(self):
        return self.kind != NEAR


class Clash:
    """Two parts that share volume (None: not known), that are one in the other, or the same."""

    def __init__(self, parts, kind, point, volume=None):
        self.parts, self.kind, self.point, self.volume = tuple(parts), kind, point, volume


class AssemblyResult:
    """What was found. parts: members.Member; frames: the placements of their patches; refused:
    {number of a part: its findings}; report: the library's JSON report as a dict with what
    FreeCAD's kernel measured under "kernel"; built: {number of a first part: api.BuildResult};
    notes: findings on how the parts were read."""

    def __init__(self, name, parts):
        self.name, self.parts = name, parts
        self.frames, self.refused = [], {}
        self.interfaces, self.clashes, self.free = [], [], []
        self.findings, self.notes = [], []
        self.report = {}
        self.built = {}
        self.joined, self.made = None, []  # after a build: Assembly, and a Solid or None per part

    @property
    def verdict(self):
        if self.clashes:
            return CLASHES
        if self.built and any(p.first not in self._solids() for p in self.parts):
            return INCOMPLETE
        return WATERTIGHT if all(i.tight for i in self.interfaces) else GAPS

    @property
    def watertight(self):
        return self.verdict == WATERTIGHT

    satisfied = watertight  # as results of other checks call it

    def _solids(self):
        return {k: r.solid for k, r in self.built.items() if r.solid is not None}

    @property
    def exit_code(self):
        """0: watertight, and all solids that were built are proved; 1: a part could not be done;
        2: gaps, clashes or a solid without proof."""
        if self.verdict == INCOMPLETE:
            return 1
        proved = all(r.verdict == "positive" for r in self.built.values())
        return 0 if self.watertight and proved else 2

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
        if self.verdict == INCOMPLETE:
            return tr("Incomplete: %d of %d parts have no solid.") % (
                sum(p.first not in self._solids() for p in self.parts), len(self.parts))
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
            lines.append("  %s: %s, gap %.3g%s%s" % (
                i.kind, self.where(i), i.gap, "" if i.tight else _at(i), _after(i)))
        for k, findings in sorted(self.refused.items()):
            text = "  %s cannot become hex blocks: %s" % (self.parts[k].name, findings[0])
            lines.append(text)
        for k, built in sorted(self.built.items()):
            lines.append("  %s: %s" % (self.parts[k].name, built.verdict))
        lines += ["  note: " + str(note) for note in self.notes]
        return "\n".join(api.visible(line) for line in lines)

    def as_dict(self):
        return self.report


def _at(row):
    if row.point is None:
        return ""
    volume = getattr(row, "volume", None)
    words = ", %.6g of volume" % volume if volume else ""
    return "%s near (%.6g, %.6g, %.6g)" % ((words,) + tuple(row.point))


def _after(i):
    """What a contact is after the build."""
    if i.gap_after is None:
        return ""
    text = ", after: gap %.3g" % i.gap_after
    if i.continuity >= 0:
        text += ", functions C^%d across its border" % i.continuity
    if i.same_bits:
        return text + ", the same functions and control points bit for bit"
    if i.same_functions:
        return text + " (%.0f ulp), the same functions" % i.ulp_after
    return text


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


def _frame(part, n_copies):
    """The placement that stays outside of a part's patches: none where it has no copies, so that
    contacts are in one frame."""
    return part.placement if n_copies > 1 else FreeCAD.Placement()


def _in_frame(part, frame):
    """The part's faces where its frame is the identity."""
    shape = part.shape.copy()
    shape.Placement = frame.inverse().multiply(shape.Placement)
    taken = api.Part.of(shape)
    taken.name = part.name
    return taken


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


# ---- the build -----------------------------------------------------------------------------------


class _OwnParameters:
    """A boundary made of patches whose parameters run over [0,1], seen in those of the faces."""

    def __init__(self, boundary, patches):
        self._boundary, self._patches = boundary, patches

    def __getattr__(self, name):
        return getattr(self._boundary, name)

    def placements(self, k):
        return [_OwnPlacement(p, self._patches[k]) for p in self._boundary.placements(k)]


class _OwnPlacement:
    def __init__(self, placement, patch):
        self._placement = placement
        self._range = [(knots[0], knots[-1]) for knots in patch.knots]
        self.domain = [a + x * (b - a) for x, (a, b) in
                       zip(placement.domain, (self._range[0],) * 2 + (self._range[1],) * 2)]

    def __getattr__(self, name):
        return getattr(self._placement, name)

    def map(self, u, v):
        (a, b), (c, d) = self._range
        return self._placement.map((u - a) / (b - a), (v - c) / (d - c))


class _Prepared(api.Part):
    """A part whose boundary is made ready for its contacts."""

    keeps_solid = True  # it knows where its patches lie, which the contacts' records need

    def __init__(self, part, assembly, number):
        super().__init__(part.sources, part.notes, part.shape, part.name)
        self._assembly, self._number = assembly, number

    def boundary(self, context, options):
        made = self._assembly.boundary(context, self._number, self.patches)
        if not self._assembly.is_prepared(self._number):
            return made
        return _OwnParameters(made, self.patches)


def build(given, options=None, gap=None, progress=None, name="Assembly"):
    """Checks, then builds every part that can become hex blocks; both sides of a contact that is
    one surface refer to the same control points, weights and knots. A part that fails is told, and
    the others are done. Copies are built once."""
    return build_parts(parts_of(given), api.options_from(options, {}), gap, progress, name)


def build_parts(parts, options, gap=None, progress=None, name="Assembly"):
    """The same of members.Member."""
    result = _started(parts, name)
    context, found, taken = _compare(result, gap, options.tolerance, progress)
    for k in sorted(taken):
        result.built[k] = api.build(_Prepared(taken[k], found, k), options, progress)
        if result.built[k].solid is None:
            _refuse(result, k, result.built[k].findings)
    for k in sorted({p.first for p in parts} - set(taken)):
        result.built[k] = api.BuildResult(parts[k].name, result.refused.get(k, []), {})
    made = [getattr(result.built[p.first], "made", None) for p in parts]
    joined = found.joined(context, made)
    result.joined, result.made = joined, made
    _after_build(result, joined, taken)
    kernel = result.report["kernel"]
    result.report = json.loads(joined.json(context))
    result.report.update(kernel=kernel, verdict=result.verdict)
    return result


# ---- the check -----------------------------------------------------------------------------------


def check(given, gap=None, tolerance=0.0, progress=None, name="Assembly"):
    """Contacts, gaps and clashes of the parts as they are; nothing is built. Works on any solids.

    given: a document, objects, or a shape. gap: how far apart faces may be to be near contacts;
    None: a hundredth of the smaller part.
    """
    return check_parts(parts_of(given), gap, tolerance, progress, name)


def check_parts(parts, gap=None, tolerance=0.0, progress=None, name="Assembly"):
    """The same of members.Member."""
    result = _started(parts, name)
    _compare(result, gap, tolerance, progress)
    return result


def _started(parts, name):
    if len(parts) < 2:
        raise ValueError("an assembly has two parts or more: %d found" % len(parts))
    copies = collections.Counter(p.first for p in parts)
    result = AssemblyResult(name, parts)
    result.frames = [_frame(p, copies[p.first]) for p in parts]
    return result


def _compare(result, gap, tolerance, progress):
    """Fills the result; gives what a build goes on with: (context, Assembly, {first: api.Part})."""
    parts = result.parts

    def tell(stage):
        def step(fraction):
            if progress is not None and progress(stage, fraction):
                raise binding.Cancelled(binding.Status.ERROR_CANCELLED, [])
        return step

    taken = _take(result, tell("shape"))
    context = binding.Context(progress)
    sources = {p.first: taken[p.first].patches if p.first in taken else [] for p in parts}
    rows = [(p.name, sources[p.first], _matrix(f)) for p, f in zip(parts, result.frames)]
    found = Assembly.create(context, rows, tolerance, gap or 0.0)
    kernel = contacts.find([p.shape for p in parts], gap, tell("kernel"))
    result.report = json.loads(found.json(context))
    result.findings += context.findings()
    _merge(result, found, kernel, taken)
    result.report["kernel"] = _kernel_dict(result, kernel)
    result.report["verdict"] = result.verdict
    return context, found, taken


def _take(result, tell):
    """{number of a first part: api.Part} of the geometries that can become hex blocks."""
    taken = {}
    firsts = sorted({p.first for p in result.parts})
    for n, k in enumerate(firsts):
        tell(n / len(firsts))
        try:
            taken[k] = _in_frame(result.parts[k], result.frames[k])
        except binding.Refused as error:
            _refuse(result, k, error.findings)
    return taken


def _refuse(result, first, findings):
    errors = [f for f in findings if f.severity == Severity.ERROR]
    for m, part in enumerate(result.parts):
        if part.first == first:
            result.refused[m] = errors


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
        # faces that are one surface in parts may be near each other elsewhere, as an arch and the
        # plate that it stands on: that is no gap of their contact
        if row.kind not in (EXACT, SAME, PARTIAL) or contact.kind != contacts.NEAR:
            row.gap, row.point = contact.gap, contact.place
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


def _after_build(result, joined, taken):
    """What the contacts have become, on the rows that are there."""
    rows = {(i.parts, i.faces): i for i in result.interfaces}
    for found in joined.interfaces:
        faces = [_face_name(taken, result.parts[p], k)
                 for p, k in zip(found["part"], found["patch"])]
        row = rows.get(_key(found["part"], faces))
        if row is None or found["same_functions"] < 0:
            continue
        for name, worse in (("same_functions", min), ("same_bits", min), ("gap_after", max),
                            ("ulp_after", max)):
            old, new = getattr(row, name), found[name]
            setattr(row, name, new if old is None else worse(old, new))
        inside = [c for c in list(found["continuity"]) + [row.continuity] if c not in (None, -1)]
        row.continuity = min(inside, default=-1)


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
