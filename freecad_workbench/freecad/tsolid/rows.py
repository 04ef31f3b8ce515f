# SPDX-License-Identifier: LGPL-2.1-or-later
"""Results as groups of rows: what, where, measured, allowed, verdict. For the panel, CSV and text;
no window is needed. What is in order is listed too.
"""

import csv
import io

from . import api, binding


def tr(text):
    """Marks a text for the window's translation (runner.tr); here it stays English."""
    return text


OK, NOTE, WARNING, BAD = VERDICTS = (tr("ok"), tr("note"), tr("warning"), tr("refused"))
COLUMNS = ("what", "where", "measured", "allowed", "verdict")


class Row:
    def __init__(
        self, what, where="", measured=None, allowed=None, verdict=OK, point=None, side=-1
    ):
        self.what, self.where = what, where
        self.measured, self.allowed = measured, allowed
        self.verdict = verdict
        self.point = None if point is None else tuple(point)
        self.side = side  # of the cube, to be shown in its colour; -1: none

    def cells(self):
        return (self.what, self.where, number(self.measured), number(self.allowed), self.verdict)

    def sentence(self):
        """The row as one line of text."""
        what, where, measured, allowed, verdict = self.cells()
        words = [what] + (["[%s]" % where] if where else [])
        words += [measured] if measured else []
        words += ["(allowed %s)" % allowed] if allowed else []
        words += ["at (%.6g, %.6g, %.6g)" % self.point] if self.point is not None else []
        return "%s: %s" % (verdict, " ".join(words))


class Group:
    def __init__(self, title, rows):
        self.title, self.rows = title, rows

    @property
    def verdict(self):
        return max((r.verdict for r in self.rows), key=VERDICTS.index, default=OK)


def number(value):
    """A cell's text."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "%.6g" % value if isinstance(value, float) else str(value)


def _is(what, measured, allowed, **more):
    return Row(what, "", measured, allowed, OK if measured == allowed else BAD, **more)


def _of_finding(f):
    """A row of a finding as a dict (binding.Finding.as_dict)."""
    verdict = {"error": BAD, "warning": WARNING, "note": NOTE}[f["severity"]]
    return Row(f["text"], f["where"], f["measured"], f["allowed"], verdict, f["point"])


# ---- check ---------------------------------------------------------------------------------------


def of_check(result):
    """Groups of an api.CheckResult."""
    findings = [_of_finding(f.as_dict()) for f in result.findings]
    out = []
    wrong = [r for r in findings if r.verdict == BAD]
    if wrong:
        out.append(Group(tr("What stands in the way"), wrong))
    out += _requirement(result.requirement)
    if result.satisfied:
        out.append(Group(tr("Six sides of the hex blocks"), _sides(result)))
        out.append(Group(tr("Eight corners"), _corners(result.requirement)))
    elif result.part is not None:
        out.append(Group(tr("Faces"), _faces(result.part, wrong)))
    rest = [r for r in findings if r.verdict != BAD]
    if rest:
        out.append(Group(tr("Notes"), rest))
    return out


def _requirement(need):
    if not need:
        return []
    rows = [
        _is(tr("watertight: every edge has two faces"), bool(need["closed"]), True),
        _is(tr("one piece"), bool(need["connected"]), True),
    ]
    if need["genus"] >= 0:
        rows.append(_is(tr("holes through the part"), need["genus"], 0))
    rows.append(Row(tr("faces, edges, vertices"), "", "%d, %d, %d" % (
        need["n_patches"], need["n_edges"], need["n_vertices"])))
    rows.append(_is(tr("violations"), need["n_violations"], 0))
    return [Group(tr("Watertight, and like a cube"), rows)]


def _sides(result):
    names = {}
    for k in range(result.boundary.n_patches):
        name = result.part.patches[k].name or "patch %d" % k
        for side in sorted({p.side for p in result.boundary.placements(k)}):
            own = names.setdefault(side, [])
            if name not in own:  # a face can be many patches
                own.append(name)
    if not names:  # Bezier elements without patches
        names = {side: [] for side in range(6)}
    grid = result.requirement["side_grid"]
    return [
        Row(binding.SIDE_NAMES[side], ", ".join(own), "%d x %d" % tuple(grid[side]), None, OK,
            side=side)
        for side, own in sorted(names.items())
    ]


def _corners(need):
    names = need.get("corner_name") or [""] * 8
    named = enumerate(zip(need["corner"], names))
    return [Row("corner %d" % k, name, None, None, OK, point) for k, (point, name) in named]


def _faces(part, wrong):
    """Every face: in order, unless a finding names it."""
    named = {word for row in wrong for word in row.where.replace(",", " ").split()}
    return [Row(tr("face"), p.name, None, None, BAD if p.name in named else OK)
            for p in part.patches]


# ---- report --------------------------------------------------------------------------------------


def _share(c):
    return c["n_elements"] - c["n_positive"]


def of_report(report):
    """Groups of a report dict, the most wanted first."""
    c, q, b = report["certificate"], report["quality"], report["basis"]
    place = c["point"] if c["verdict"] != "positive" else None
    proved = Row(tr("hex blocks not proved free of folds"), "", _share(c), 0,
                 OK if c["verdict"] == "positive" else BAD, place)
    out = [
        Group(tr("Hex blocks do not fold (det J > 0)"), [
            Row(tr("hex blocks"), "", c["n_elements"], None),
            proved,
            Row(tr("smallest proved bound of det J"), "", c["smallest_bound"], 0.0, proved.verdict),
        ]),
        Group(tr("Conformal contact faces"), _exactness(report)),
        Group(tr("Watertight, and like a cube"), _report_requirement(report["requirement"])),
        Group(tr("Shape of the hex blocks"), [
            Row(tr("worst scaled Jacobian"), "", q["worst"], 0.0, OK if q["worst"] > 0 else BAD,
                q["worst_point"]),
            Row(tr("best that the part's faces allow"), "", q["bound"], None, OK, q["bound_point"]),
            Row(tr("worst, compared with that"), "", q["ratio"], None),
            Row(tr("mean scaled Jacobian"), "", q["mean"], None),
        ]),
        Group(tr("Volume"), _volume(report)),
        Group(tr("Smoothness inside"), _continuity(report["continuity"])),
        Group(tr("T-spline functions"), [
            Row(tr("functions"), "", report["statistics"]["n_functions"], None),
            _sum(b, report["statistics"].get("analysis_suitable", True)),
            Row(tr("smallest coefficient"), "", b["smallest_value"], 0.0,
                OK if b["smallest_value"] >= 0 else BAD),
            _rank(b, "inner"), _rank(b, "surface"),
        ]),
    ]
    findings = [_of_finding(f) for f in report["findings"]
                if f["severity"] != "note" or f["stage"] not in ("exactness", "volume")]
    if findings:
        out.append(Group(tr("Notes"), findings))
    out.append(Group(tr("Time"), [Row(k.replace("_", " "), "", float(v), None)
                                  for k, v in report["timing"].items() if v is not None]))
    return [g for g in out if g.rows]


def _exactness(report):
    c = report["conformity"]
    rows = [Row(tr("distance of the face from the solid"), r["face"], r["distance"], r["allowed"],
                OK if r["satisfied"] else BAD, r["point"]) for r in report["exactness"]]
    rows.append(_is(tr("control points of the faces kept bit for bit"),
                    bool(c["control_identical"]), True))
    return rows


def _report_requirement(need):
    groups = _requirement(need)
    return groups[0].rows if groups else []


def _volume(report):
    c, v = report["conformity"], report.get("volume")
    rows = [Row(tr("volume of the hex blocks"), "", c["volume"], None),
            Row(tr("volume inside the faces"), "", v["flux"] if v else c["flux"], None)]
    if v:
        rows.append(Row(tr("relative difference"), "", v["relative_difference"], v["allowed"],
                        OK if v["satisfied"] else BAD))
    return rows


def _continuity(c):
    names = (tr("area of inner faces: torn"), tr("area of inner faces: continuous"),
             tr("area of inner faces: tangent planes too"),
             tr("area of inner faces: curvature too"))
    rows = [Row(name, "", area, 0.0 if k == 0 else None,
                BAD if k == 0 and area else OK)
            for k, (name, area) in enumerate(zip(names, c["area"])) if area is not None]
    rows.append(_is(tr("inner faces less smooth than they should be"), c["n_below_expected"], 0))
    return rows


def _sum(b, analysis_suitable):
    """What the input's own functions lack stays; without the closure the solid is rational."""
    value, allowed = b["sum_defect"], 1e-12 + (b.get("input_sum_defect") or 0.0)
    otherwise = BAD if analysis_suitable else NOTE
    return Row(tr("their sum differs from 1 by"), "", value, allowed,
               OK if value <= allowed else otherwise)


def _rank(b, kind):
    value, least = b[kind + "_eigenvalue"], b[kind + "_roundoff"]
    what = {"inner": tr("independence of the inner functions (smallest eigenvalue)"),
            "surface": tr("independence of the surface functions (smallest eigenvalue)")}[kind]
    if not b["rank_measured"] or value is None:
        return Row(what, "", "not measured: too many", None, NOTE)
    return Row(what, "", value, least, OK if value > least else BAD)


# ---- assemblies ----------------------------------------------------------------------------------

_CONTACTS = {
    "exact": tr("one surface: same functions and control points"),
    "geometric": tr("one surface, after exact refinement"),
    "partial": tr("one surface, in part"),
    "coincident": tr("on each other within the tolerance"),
    "near": tr("gap"),
}
_CLASHES = {
    "overlap": tr("parts penetrate each other"),
    "inside": tr("a part lies inside another"),
    "twice": tr("the same part twice in the same place"),
    "self": tr("a part touches itself"),
}


def of_assembly(result):
    """Groups of an assemblies.AssemblyResult; rows know what to select (part, face) in `items`."""
    out = []
    if result.clashes:
        out.append(Group(tr("Clashes"), [_clash(result, c) for c in result.clashes]))
    gaps = [i for i in result.interfaces if not i.tight]
    if gaps:
        out.append(Group(tr("Gaps between parts"), [_interface(result, i) for i in gaps]))
    tight = [i for i in result.interfaces if i.tight]
    if tight:
        out.append(Group(tr("Conformal contact faces"), [_interface(result, i) for i in tight]))
    out.append(Group(tr("Parts"), [_part(result, k) for k in range(len(result.parts))]))
    free = [_with_items(Row(tr("free face"), "%s %s" % (result.parts[k].name, face)), (k, face))
            for k, face in result.free]
    if free:
        out.append(Group(tr("Free faces"), free))
    return out


def _with_items(row, *items):
    row.items = items
    return row


def _interface(result, i):
    row = Row(_CONTACTS[i.kind], result.where(i), i.gap, 0.0 if not i.tight else None,
              OK if i.tight else BAD, i.point)
    return _with_items(row, *zip(i.parts, i.faces))


def _clash(result, c):
    row = Row(_CLASHES[c.kind], result.where(c), c.volume, None, BAD, c.point)
    return _with_items(row, *((k, "") for k in c.parts))


def _part(result, k):
    why = result.refused.get(k)
    name = result.parts[k].name
    if why:
        row = Row(tr("cannot become hex blocks") + ": " + str(why[0]), name, None, None, NOTE)
    else:
        row = Row(tr("can become hex blocks"), name)
    return _with_items(row, (k, ""))


def of_result(result):
    """Groups and headline of a check of either kind."""
    if hasattr(result, "interfaces"):
        return of_assembly(result), result.headline()
    return of_check(result), headline_of_check(result)


# ---- out of the window ---------------------------------------------------------------------------


def csv_text(groups):
    stream = io.StringIO()
    writer = csv.writer(stream)
    writer.writerow(("group",) + COLUMNS + ("x", "y", "z"))
    for group in groups:
        for row in group.rows:
            point = ("", "", "") if row.point is None else ["%.17g" % x for x in row.point]
            cells = [api.visible(c) for c in (group.title,) + row.cells()]
            writer.writerow(cells + list(point))
    return stream.getvalue()


def text(title, groups):
    """For the clipboard: one line per row."""
    lines = [api.visible(title)]
    for group in groups:
        lines.append("%s: %s" % (group.title, group.verdict))
        for row in group.rows:
            lines.append("  " + api.visible(row.sentence()))
    return "\n".join(lines) + "\n"


def headline_of_check(result, tr=tr):
    if result.satisfied:
        return tr("Yes: this part can become hex blocks.")
    n = sum(1 for f in result.findings if f.severity == binding.Severity.ERROR)
    if n == 1:
        return tr("Not as it is: 1 thing stands in the way.")
    return tr("Not as it is: %d things stand in the way.") % n


def headline_of_report(report, tr=tr):
    c, q = report["certificate"], report["quality"]
    if report["verdict"] == "positive":
        return tr("Valid: %d hex blocks, none folds; worst scaled Jacobian %.3g.") % (
            c["n_elements"], q["worst"])
    if report["verdict"] == "undecided":
        return tr("Built, but not proved everywhere: %d of %d hex blocks are undecided.") % (
            c["n_undecided"], c["n_elements"])
    return tr("Not valid (%s): do not use this solid.") % report["verdict"]
