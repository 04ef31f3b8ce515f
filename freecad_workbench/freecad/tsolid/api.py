# SPDX-License-Identifier: LGPL-2.1-or-later
"""check() and build() for scripts, panels and commands alike.

    import freecad.tsolid as ts
    result = ts.check(App.ActiveDocument.Box)
    print(result.text())
    result = ts.build(App.ActiveDocument.Box, effort="thorough", threads=2)
    result.report["quality"]["worst"]
    result.write("part.tsolid")

Both take a document object with a Shape, or a shape, and give a result also when the part is
refused: findings then say what, where, measured and allowed.
"""

import json
import math
import os
import tempfile
import time

from . import binding, convert, evidence, intake_suggest
from .header import Severity, Status, Verdict

EFFORTS = ("default", "none", "quick", "thorough")  # the library's numbers 0..3
OCTREES = ("anisotropic", "isotropic")  # the library's 0 and 1
VOLUME_ALLOWED = 1e-12

# A part that fails so is refused; anything else is an error of the machine or of ours.
_ABOUT_THE_PART = (Status.ERROR_REFUSED, Status.ERROR_INPUT, Status.ERROR_NUMERIC)


class Options:
    """How to build. All defaults are sensible.

    refine_knots: halve every knot span of the sides so often, exactly (more freedom inside)
    raise_degree: raise the degree of every side by so much, exactly
    min_cells:    at least so many cells per axis inside; 0: the library's default
    octree:       "anisotropic": levels per axis; "isotropic": the paper's
    analysis_suitable: functions that sum to one (as far as the input's own do); False: a rational
                  T-spline with fewer elements
    effort:       "default", "none" (no smoothing), "quick" or "thorough"
    threads:      0 takes all processors; the result does not depend on it
    tolerance:    of edges that carry none of their own, in the shape's unit; 0: 1e-7
    corners:      names of vertices ("Vertex3") that have to be corners of the cube, eight or
                  fewer, where a part with planar faces can be seen as a cube in several ways
    """

    def __init__(
        self,
        refine_knots=0,
        raise_degree=0,
        min_cells=0,
        effort="default",
        threads=0,
        tolerance=0.0,
        octree="anisotropic",
        analysis_suitable=True,
        corners=(),
    ):
        if effort not in EFFORTS:
            raise ValueError("effort is one of %s" % ", ".join(EFFORTS))
        if octree not in OCTREES:
            raise ValueError("octree is one of %s" % ", ".join(OCTREES))
        if not 0.0 <= tolerance < math.inf:
            raise ValueError("tolerance is a number, and not negative")
        if isinstance(corners, str) or len(set(corners)) > 8:
            raise ValueError("corners is a list of at most eight names of vertices")
        self.refine_knots = int(refine_knots)
        self.raise_degree = int(raise_degree)
        self.min_cells = int(min_cells)
        self.octree = octree
        self.analysis_suitable = bool(analysis_suitable)
        self.effort = effort
        self.threads = int(threads)
        self.tolerance = float(tolerance)
        self.corners = tuple(str(name) for name in corners)

    def of_boundary(self):
        return self.tolerance, self.refine_knots, self.raise_degree

    def as_dict(self):
        """What the result depends on: not the number of threads."""
        names = ("refine_knots", "raise_degree", "min_cells", "octree", "analysis_suitable",
                 "effort", "tolerance")
        return dict({name: getattr(self, name) for name in names}, corners=list(self.corners))


def options_from(options, keywords):
    """The Options object given, or one made of keywords."""
    if options is not None and keywords:
        raise TypeError("give an Options object or keywords, not both")
    return options if options is not None else Options(**keywords)


# ---- what comes in ---------------------------------------------------------------------------


def notes_of(given):
    """What was found when a document object's surface was read: see files.py."""
    name = getattr(given, "Label", "")
    texts = getattr(given, "Notes", ())
    return [binding.finding(Severity.NOTE, "surface", name, text) for text in texts]


class Part:
    """The faces of one part, as sources that can be measured, and notes on their conversion."""

    keeps_solid = False  # whether a build's result keeps the solid as built, not only as stored

    def __init__(self, sources, notes=(), shape=None, name=""):
        self.sources = sources
        self.patches = [p for s in sources for p in s.patches]
        self.notes = list(notes)
        self.shape = shape  # the solid made of the input's very faces; None: not made yet
        self.name = name
        self.file = None  # a BoundaryFile that holds Bezier elements instead of patches

    @classmethod
    def of(cls, given, tell=None, corners=()):
        """From a document object, a shape, or a Part; raises Refused. tell(fraction) is called
        for every face and may raise. corners: names of vertices that have to be the cube's."""
        if isinstance(given, cls):
            return given
        name = getattr(given, "Label", "")
        shape = convert.shape_of(given)
        try:
            sources, notes = convert.sources_of_shape(shape, tell, corners)
        except binding.Refused as error:
            error.findings += intake_suggest.findings(shape)
            raise
        return cls(sources, notes_of(given) + notes, shape.Solids[0], name)

    @classmethod
    def of_patches(cls, patches, name=""):
        """From patches that no shape stands behind; nothing is checked yet."""
        part = cls([], name=name)
        part.patches = list(patches)
        return part

    @classmethod
    def read_tsb(cls, path, name=""):
        """From a .tsb file; raises TsolidError."""
        given = binding.BoundaryFile.read(binding.Context(), path)
        part = cls.of_patches(given.patches(), name)
        part.file = None if part.patches else given
        return part

    def boundary(self, context, options):
        """The checked boundary; only then OCC sees patches that came without a shape."""
        if self.file is not None:
            return binding.Boundary.from_file(context, self.file, *options.of_boundary())
        boundary = binding.Boundary.create(context, self.patches, *options.of_boundary())
        if not self.sources:
            numbered = enumerate(self.patches)
            self.sources = [convert.source_of_patch(p, k) for k, p in numbered]
        return boundary

    def solid_shape(self, boundary):
        """The closed valid solid of the part's faces."""
        if self.shape is None:
            patches = self.patches or convert.patches_of_boundary(boundary)
            self.shape = convert.solid_of_patches(patches)
        return self.shape


# ---- results ---------------------------------------------------------------------------------

_VERDICTS = {Severity.ERROR: "refused", Severity.WARNING: "warning", Severity.NOTE: "note"}


class CheckResult:
    """Can the part become a solid, and where not?"""

    shape = None  # the shape that was checked, where one was given as a document object

    def __init__(self, name, findings, requirement, part=None, boundary=None):
        self.name = name
        self.findings = findings
        self.requirement = requirement  # as far as the check got; {} when it did not start
        self.part = part
        self.boundary = boundary

    @property
    def satisfied(self):
        return self.boundary is not None

    @property
    def verdict(self):
        return "satisfied" if self.satisfied else "refused"

    def rows(self):
        """One row per finding: what, where, measured, allowed, verdict, point."""
        return [
            {
                "what": f.text,
                "where": f.where,
                "measured": f.measured,
                "allowed": f.allowed,
                "verdict": _VERDICTS[f.severity],
                "point": f.point,
            }
            for f in self.findings
        ]

    def as_dict(self):
        return {
            "format": "tsolid check",
            "version": 1,
            "part": self.name,
            "verdict": self.verdict,
            "requirement": self.requirement,
            "findings": [f.as_dict() for f in self.findings],
        }

    def text(self):
        lines = ["%s: %s" % (visible(self.name) or "part", self.verdict)]
        if self.satisfied:
            need = self.requirement
            lines.append(
                "  %d faces, %d edges, %d vertices; closed, genus %d; eight corners, 12 isolines"
                % (need["n_patches"], need["n_edges"], need["n_vertices"], need["genus"])
            )
        shown = [
            f for f in self.findings
            if self.satisfied or f.severity != Severity.NOTE or f.stage == intake_suggest.STAGE
        ]
        return "\n".join(lines + _finding_lines(shown))


def visible(text):
    """Names come from files: a newline in one must not look like another line."""
    return "".join(c if c.isprintable() else "\\x%02x" % ord(c) for c in text)


def _finding_lines(findings):
    return ["  %s: %s" % (_VERDICTS[f.severity], visible(str(f))) for f in findings]


class BuildResult(CheckResult):
    """The solid and its report; solid is None when the part was refused."""

    solid = None  # read back from the .tsolid bytes
    tsolid = None  # the .tsolid file's bytes
    report = None  # the report as a dict
    shape = None  # closed valid solid made of the input's very faces
    options = None

    @property
    def proved(self):
        """det J > 0 everywhere, and all evidence within its allowance."""
        return self.solid is not None and self.report["verdict"] == "positive"

    @property
    def exit_code(self):
        return 1 if self.solid is None else 0 if self.proved else 2

    @property
    def verdict(self):
        return "refused" if self.solid is None else self.report["verdict"]

    def write(self, path):
        """Writes the .tsolid bytes: beside the path, then renamed."""
        write_beside(path, lambda beside: _write_bytes(beside, self.tsolid))

    def write_report(self, path):
        text = report_json(self.report)
        write_beside(path, lambda beside: _write_bytes(beside, text.encode()))

    def write_vtu(self, path):
        context = binding.Context()
        self.solid.write_vtu(context, path)

    def text(self):
        if self.solid is None:
            return CheckResult.text(self)
        return report_text(self.report)


def report_json(report):
    return json.dumps(report, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def _write_bytes(path, data):
    with open(path, "wb") as stream:
        stream.write(data)


def write_beside(path, write):
    """Calls write(beside) with a new name in the same directory, then renames it to path."""
    path = os.path.abspath(path)
    handle, beside = tempfile.mkstemp(prefix=".tsolid-", dir=os.path.dirname(path))
    os.close(handle)
    try:
        write(beside)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(beside, 0o666 & ~umask)
        os.replace(beside, path)
    except BaseException:
        os.unlink(beside)
        raise


# ---- check -----------------------------------------------------------------------------------


def check(given, options=None, progress=None, **keywords):
    """Can the part become a solid T-spline? progress(stage, fraction) may return true to cancel."""
    options = options_from(options, keywords)
    context = binding.Context(progress, options.threads)
    return _check(CheckResult, given, options, context)


def _check(kind, given, options, context):
    name = getattr(given, "name", "") or getattr(given, "Label", "")
    part = None
    try:
        part = Part.of(given, corners=options.corners)
        boundary = part.boundary(context, options)
    except binding.TsolidError as error:
        if error.status not in _ABOUT_THE_PART:
            raise
        notes = part.notes if part is not None else []
        requirement = getattr(error, "requirement", None) or {}
        return kind(name, notes + _unique(context.findings() + error.findings), requirement)
    findings = part.notes + context.findings()
    return kind(part.name, findings, boundary.requirement, part, boundary)


def _unique(findings):
    """Without repetitions: an error's findings are among the context's too."""
    out = []
    for f in findings:
        if not any(repr(f) == repr(g) for g in out):  # repr: a NaN equals itself
            out.append(f)
    return out


# ---- build -----------------------------------------------------------------------------------


class _Clock:
    """Seconds per stage."""

    def __init__(self):
        self.start = self.last = time.perf_counter()
        self.seconds = {}

    def stop(self, stage):
        now = time.perf_counter()
        self.seconds[stage] = now - self.last
        self.last = now

    def times(self):
        return dict(self.seconds, total=time.perf_counter() - self.start)


def build(given, options=None, progress=None, **keywords):
    """Builds, proves and measures; a result with findings when the part is refused."""
    options = options_from(options, keywords)
    context = binding.Context(progress, options.threads)
    clock = _Clock()
    result = _check(BuildResult, given, options, context)
    result.options = options
    clock.stop("boundary")
    if not result.satisfied:
        return result
    try:
        built = _solid(context, result.boundary, options, clock)
    except binding.TsolidError as error:
        if error.status not in _ABOUT_THE_PART:
            raise
        result.findings = _unique(result.findings + context.findings() + error.findings)
        return result
    result.tsolid, result.solid = _through_file(context, built)
    result.made = built if result.part.keeps_solid else None
    result.shape = result.part.solid_shape(result.boundary)
    measured = binding.Report.measure(context, result.solid)
    clock.stop("report")
    result.findings = _unique(result.findings + context.findings())
    result.report = _report(context, result, options, measured, clock)
    return result


def _solid(context, boundary, options, clock):
    tmesh = binding.TMesh.create(context, boundary, options.min_cells,
                                 OCTREES.index(options.octree), options.analysis_suitable)
    clock.stop("tmesh")
    space = binding.Space.create(context, boundary, tmesh)
    clock.stop("space")
    solid = binding.Solid.create(context, space)
    clock.stop("start")
    solid = solid.optimised(context, EFFORTS.index(options.effort))
    clock.stop("optimise")
    return solid


def _through_file(context, solid):
    """The .tsolid bytes, and the solid rebuilt from them alone: all that is measured is that."""
    with tempfile.TemporaryDirectory(prefix="tsolid-") as folder:
        path = os.path.join(folder, "solid.tsolid")
        solid.write(context, path)
        with open(path, "rb") as stream:
            data = stream.read()
        return data, binding.Solid.read(context, path)


def read_tsolid(context, data):
    """The solid that .tsolid bytes hold."""
    with tempfile.TemporaryDirectory(prefix="tsolid-") as folder:
        path = os.path.join(folder, "solid.tsolid")
        _write_bytes(path, data)
        return binding.Solid.read(context, path)


def verify(given, data, options=None, **keywords):
    """Exactness rows of a part against .tsolid bytes alone, and whether the control points agree.

    The part's boundary is made anew, with the options of the build, only to learn where each face
    lies on the cube; every point of the solid comes from the bytes.
    """
    options = options_from(options, keywords)
    context = binding.Context(threads=options.threads)
    part = Part.of(given, corners=options.corners)
    boundary = part.boundary(context, options)
    solid = read_tsolid(context, data)
    same = solid.boundary.points.tolist() == boundary.points.tolist()
    return evidence.exactness(context, part.sources, boundary, solid), same


def _peak_memory():
    try:
        import resource
    except ImportError:  # Windows
        return float("nan")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _report(context, result, options, measured, clock):
    """The library's report with what only the CAD side can know."""
    rows, volume = measure_evidence(context, result.part, result.boundary, result.solid, measured)
    clock.stop("evidence")
    seconds = clock.times()
    seconds.pop("evidence")
    measured.set_times(peak_memory_mib=_peak_memory(), **seconds)
    report = measured.facts()
    report["part"] = result.part.name
    report["options"] = options.as_dict()
    report["exactness"] = rows
    report["volume"] = volume
    result.findings += _evidence_findings(rows, volume)
    report["findings"] = [f.as_dict() for f in result.findings]
    report["verdict"] = _verdict(measured, rows, volume)
    return report


def report_of_solid(context, solid, name):
    """The report of a solid of which no faces are known: no exactness, no CAD kernel's volume."""
    measured = binding.Report.measure(context, solid)
    measured.set_times(peak_memory_mib=_peak_memory())
    report = measured.facts()
    report.update(part=name, options={}, exactness=[], volume=None)
    report["findings"] = [f.as_dict() for f in context.findings()]
    report["verdict"] = _verdict(measured, [], None)
    return report


def measure_evidence(context, part, boundary, solid, measured):
    """Exactness rows and the volume's comparison, by OCC's own surfaces."""
    if not part.sources:
        return [], None
    rows = evidence.exactness(context, part.sources, boundary, solid)
    return rows, _volume(context, part, boundary, measured.struct.conformity.volume, rows)


def _volume(context, part, boundary, quadrature, rows):
    import FreeCAD

    corners = [FreeCAD.Vector(*p) for p in boundary.requirement["corner"]]
    centre = sum(corners, FreeCAD.Vector()) * 0.125
    numbered = enumerate(part.sources)  # without a shape there is one patch to a face
    signs = [s.sign or evidence.sign_on_cube(boundary.placements(k)[0]) for k, s in numbered]
    # a solid turned inside out is the same part
    flux = abs(evidence.volume_by_flux(part.sources, signs, centre, abs(quadrature), context))
    difference = abs(flux - quadrature) / flux if flux else 1.0
    declared = evidence.volume_declared(part.sources, rows, centre, boundary.scale)
    declared = declared / flux if flux else 0.0
    return {
        "quadrature": quadrature,
        "flux": flux,
        "relative_difference": difference,
        "declared": declared,
        "allowed": VOLUME_ALLOWED + declared,
        "satisfied": difference <= VOLUME_ALLOWED + declared,
    }


def _evidence_findings(rows, volume):
    out = []
    for row in rows:
        out.append(
            binding.finding(
                Severity.NOTE if row["satisfied"] else Severity.ERROR,
                "exactness",
                row["face"],
                "distance of the face as read from the solid",
                row["point"],
                row["distance"],
                row["allowed"],
            )
        )
    if volume is not None:
        out.append(
            binding.finding(
                Severity.NOTE if volume["satisfied"] else Severity.ERROR,
                "volume",
                "",
                "relative difference of the solid's volume from the flux through the faces",
                None,
                volume["relative_difference"],
                volume["allowed"],
            )
        )
    return out


def _verdict(measured, rows, volume):
    if not all(row["satisfied"] for row in rows):
        return "not conformal"
    if volume is not None and not volume["satisfied"]:
        return "volume differs"
    return {
        Verdict.POSITIVE: "positive",
        Verdict.NOT_POSITIVE: "not positive",
        Verdict.UNDECIDED: "undecided",
    }[measured.verdict]


# ---- the report in words ---------------------------------------------------------------------


def _number(value):
    return "unknown" if value is None else "%.6g" % value


def report_text(report):
    """The report's facts as lines for a person."""
    quality, certificate = report["quality"], report["certificate"]
    statistics, basis = report["statistics"], report["basis"]
    worst = max(report["exactness"], key=lambda r: r["distance"] / r["allowed"], default=None)
    lines = [
        "%s: %s" % (visible(report["part"]) or "part", report["verdict"]),
        "  elements: %d (%d functions, %d of them inside)"
        % (statistics["bezier_elements"], statistics["n_functions"], statistics["n_inner"]),
        "  det J > 0: proved on %d of %d elements"
        % (certificate["n_positive"], certificate["n_elements"]),
        "  scaled Jacobian: worst %s, mean %s, best %s; the part allows %s, ratio %s"
        % tuple(_number(quality[k]) for k in ("worst", "mean", "best", "bound", "ratio")),
        "  sum of the functions differs from 1 by %s (of which the input's own: %s)"
        % (_number(basis["sum_defect"]), _number(basis.get("input_sum_defect"))),
    ]
    if worst is not None:
        lines.append(
            "  exact: %d faces, worst %s, distance %s, allowed %s"
            % (
                len(report["exactness"]),
                worst["face"],
                _number(worst["distance"]),
                _number(worst["allowed"]),
            )
        )
    volume = report["volume"]
    if volume is not None:
        lines.append(
            "  volume: %.15g, flux through the faces %.15g, relative difference %s"
            % (volume["quadrature"], volume["flux"], _number(volume["relative_difference"]))
        )
    lines += ["  %s: %s" % (_word(f), _line(f)) for f in report["findings"] if _is_news(f)]
    return "\n".join(lines)


def _is_news(f):
    return f["severity"] != "note" or f["stage"] not in ("exactness", "volume")


def _word(f):
    return _VERDICTS[Severity[f["severity"].upper()]]


def _line(f):
    point = None if f["point"] is None else tuple(f["point"])
    severity = Severity[f["severity"].upper()]
    numbers = (f["measured"], f["allowed"])
    return visible(
        str(binding.finding(severity, f["stage"], f["where"], f["text"], point, *numbers))
    )
