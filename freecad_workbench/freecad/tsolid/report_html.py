# SPDX-License-Identifier: LGPL-2.1-or-later
"""A report (resources/report.schema.json) as one HTML page for an engineer: no scripts, nothing
loaded from elsewhere, pictures inside. Every number stands in the report; this only words it.
"""

import base64
import html
import io
import os

from . import binding, picture

STYLE = """
body { font: 15px/1.45 sans-serif; color: #1c2430; max-width: 62em; margin: 2em auto;
  padding: 0 1em }
h1 { font-size: 1.6em; margin: 0 0 .3em }
h2 { font-size: 1.15em; margin: 1.8em 0 .4em }
.verdict { border-left: .5em solid; padding: .6em 1em; margin: 1em 0 }
.verdict strong { display: block; font-size: 1.15em }
.verdict ul { margin: .4em 0 0; padding-left: 1.2em }
.good { border-color: #2e7d32; background: #eef7ee }
.bad { border-color: #c62828; background: #fdeeee }
.unsure { border-color: #b26a00; background: #fff6e6 }
table { border-collapse: collapse; margin: .4em 0 }
td, th { padding: .2em .8em .2em 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid #dde2e8 }
th { font-weight: 600 }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
figure { margin: 1em 0 }
img { max-width: 100%; border: 1px solid #dde2e8 }
figcaption, .note { color: #55606e; font-size: .92em }
@media print { body { margin: 0; max-width: none } figure, table { break-inside: avoid } }
"""

SIDES = ("x low", "x high", "y low", "y high", "z low", "z high")


# ---- small pieces --------------------------------------------------------------------------------


def _text(value):
    return html.escape(str(value))


def _number(value, digits=6):
    if value is None:
        return "not measured"
    if isinstance(value, bool):  # before int: a bool is one
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    return "%.*g" % (digits, value)


def _place(point):
    return "(%s)" % ", ".join(_number(x) for x in point)


def _relative(a, b):
    return abs(a - b) / abs(b) if a is not None and b else None


def _is_number(cell):
    return cell is None or isinstance(cell, (int, float))


def _cell(tag, cell, to_the_right):
    kind = ' class="number"' if to_the_right else ""
    return "<%s%s>%s</%s>" % (tag, kind, _number(cell) if _is_number(cell) else _text(cell), tag)


def _facts(rows):
    """Two columns: what, and how much. Cells are escaped here."""
    lines = [_cell("td", name, False) + _cell("td", value, False) for name, value in rows]
    return "<table>%s</table>" % "\n".join("<tr>%s</tr>" % line for line in lines)


def _table(rows, head):
    """A table under a head; columns that start with a number stand to the right."""
    right = [_is_number(cell) for cell in rows[0]]
    lines = ["".join(_cell("th", c, r) for c, r in zip(head, right))]
    lines += ["".join(_cell("td", c, r) for c, r in zip(row, right)) for row in rows]
    return "<table>%s</table>" % "\n".join("<tr>%s</tr>" % line for line in lines)


def _section(title, *parts):
    body = "\n".join(part for part in parts if part)
    return "<section>\n<h2>%s</h2>\n%s\n</section>" % (_text(title), body)


def _note(text):
    return '<p class="note">%s</p>' % _text(text)


def _paragraph(text):
    return "<p>%s</p>" % _text(text)


# ---- verdict -------------------------------------------------------------------------------------


def _rank_is_full(basis):
    pairs = (("inner_eigenvalue", "inner_roundoff"), ("surface_eigenvalue", "surface_roundoff"))
    return all(basis[a] is not None and basis[a] > basis[b] for a, b in pairs)


def shortcomings(report):
    """What keeps the solid from being all that it should be, in sentences; [] if nothing does."""
    found = []
    certificate, basis = report["certificate"], report["basis"]
    if not report["requirement"]["satisfied"]:
        found.append("The faces do not meet the requirement for a solid T-spline.")
    if certificate["verdict"] == "not positive":
        found.append(
            "The Jacobian determinant is not positive at %s." % _place(certificate["point"])
        )
    if certificate["verdict"] == "undecided":
        found.append(
            "On %d of %d elements the Jacobian determinant is neither proved positive nor "
            "disproved, first near %s."
            % (certificate["n_undecided"], certificate["n_elements"], _place(certificate["point"]))
        )
    if not report["conformity"]["control_identical"]:
        found.append("The boundary's control points are not those of the prepared faces.")
    for row in report.get("exactness", []):
        if not row["satisfied"]:
            found.append(
                "%s is %s away from the solid, more than the %s allowed."
                % (row["face"], _number(row["distance"]), _number(row["allowed"]))
            )
    volume = report.get("volume")
    if volume and not volume["satisfied"]:
        found.append("The volume differs from the flux through the faces.")
    if basis["rank_measured"] and not _rank_is_full(basis):
        found.append("The functions are not linearly independent.")
    if report["continuity"]["n_below_expected"]:
        found.append(
            "%d inner element faces are less smooth than they should be."
            % report["continuity"]["n_below_expected"]
        )
    if not found and report.get("verdict", "positive") != "positive":
        found.append("The evidence together says: %s." % report["verdict"])
    return found


def _verdict(report):
    missing = shortcomings(report)
    certificate = report["certificate"]
    if not missing:
        kind, head = "good", "Valid: the solid has the part's own faces and is proved sound."
    elif certificate["verdict"] == "undecided" and len(missing) == 1:
        kind, head = "unsure", "Built, but not proved everywhere."
    else:
        kind, head = "bad", "Not valid: do not use this solid."
    lines = ["<strong>%s</strong>" % _text(head)]
    if missing:
        lines.append("<ul>%s</ul>" % "".join("<li>%s</li>" % _text(m) for m in missing))
    else:
        lines.append(_text(_good_news(report)))
    return '<div class="verdict %s">%s</div>' % (kind, "\n".join(lines))


def _good_news(report):
    certificate, quality = report["certificate"], report["quality"]
    text = "det J > 0 is proved on all %d elements" % certificate["n_elements"]
    if certificate["n_singular"]:
        text += ", but for corners where the part itself is singular"
    text += "; the worst scaled Jacobian is %s" % _number(quality["worst"], 3)
    if quality["bound"] is not None:
        text += ", where the part's shape allows %s at best" % _number(quality["bound"], 3)
    return text + "."


# ---- sections ------------------------------------------------------------------------------------


def _requirement(report):
    r = report["requirement"]
    rows = [
        ("satisfied", r["satisfied"]),
        ("faces", r["n_patches"]),
        ("edges, vertices of the faces", "%d, %d" % (r["n_edges"], r["n_vertices"])),
        ("closed, connected", "%s, %s" % (_number(r["closed"]), _number(r["connected"]))),
        ("genus", r["genus"] if r["genus"] >= 0 else "not known"),
        ("extraordinary vertices (8 wanted)", r["n_extraordinary"]),
        ("violations", r["n_violations"]),
    ]
    parts = [_facts(rows)]
    if r["corner"]:
        names = r.get("corner_name") or [""] * len(r["corner"])
        corners = [
            (("%d %s" % (k, name)).strip(), *map(float, point))
            for k, (point, name) in enumerate(zip(r["corner"], names))
        ]
        parts.append(_paragraph("Corners of the cube that the part is taken as:"))
        parts.append(_table(corners, ("corner", "x", "y", "z")))
    return _section("Requirement: six sides, twelve edges, eight corners", *parts)


def _preparation(report):
    p = report["preparation"]
    rows = []
    for name, values in (("edge", p["snap"]), ("border inside side", p["snap_inside"])):
        for k, value in enumerate(values):
            if value is None or value > 0:
                rows.append(("snapped, %s %d: moved by at most" % (name, k), value))
    for side, factor in enumerate(p["weight_factor"]):
        if factor != 1:
            rows.append(("weights of side %s multiplied by" % SIDES[side], factor))
    labels = (
        ("knot_merge", "knots of two sides taken as one, differing by (of their range)"),
        ("n_knots_merged", "such knots"),
        ("n_knots_inserted", "knots inserted (exact)"),
        ("n_degrees_raised", "degrees raised (exact)"),
        ("n_cut_patches", "faces cut at vertices of their neighbours (exact)"),
        ("n_cuts", "isolines of these cuts, with functions C^0 across"),
        ("refine_knots", "asked for: halvings of every knot span (exact)"),
        ("raise_degree", "asked for: degrees raised (exact)"),
    )
    values = [(label, p.get(key, 0)) for key, label in labels]
    rows += [(label, value) for label, value in values if value is None or value > 0]
    if not rows:
        nothing = _paragraph("Nothing was changed: the faces are used as read.")
        return _section("Preparation", nothing)
    return _section("Preparation: what was changed before the construction", _facts(rows))


def _sides_of(row):
    """The sides on which a face lies; reports of older documents know one only."""
    pieces = row.get("pieces") or [row]
    return ", ".join(SIDES[side] for side in sorted({p["side"] for p in pieces}))


def _exactness(report):
    conformity = report["conformity"]
    parts = []
    if report.get("exactness"):
        rows = [
            (r["face"], _sides_of(r), r["kind"], r["distance"], r["allowed"], r["declared"],
             r["conversion"], "yes" if r["satisfied"] else "NO")
            for r in report["exactness"]
        ]
        head = ("face", "side", "surface as read", "distance", "allowed", "declared change",
                "conversion", "within")
        samples = report["exactness"][0]["samples"]
        parts.append(_table(rows, head))
        parts.append(_note(
            "Largest distance of %d random points per face, as the CAD kernel evaluates the face "
            "that was read, from the solid read back from its file. Allowed: 1e-12 of the scale "
            "plus the declared change." % samples))
    parts.append(_facts([
        ("distance to the prepared boundary, by the library's two evaluators",
         conformity["distance"]),
        ("at so many points", conformity["n_samples"]),
        ("scale (diagonal or largest coordinate)", conformity["scale"]),
        ("boundary control points bit for bit those of the faces",
         conformity["control_identical"]),
    ]))
    return _section("Exactness, face by face", *parts)


def _continuity(report):
    c = report["continuity"]
    total = sum(a for a in c["area"] if a is not None)
    names = ("torn (C^-1)", "continuous (C^0)", "tangent planes (C^1)", "curvature (C^2) or more")
    rows = []
    for name, area in zip(names, c["area"]):
        share = 100 * area / total if total and area is not None else None
        rows.append((name, area, None if share is None else "%.1f %%" % share))
    return _section(
        "Continuity inside",
        _table(rows, ("measured on the faces between elements", "area", "share")),
        _facts([
            ("faces measured", c["n_faces"]),
            ("less smooth than the theory says", c["n_below_expected"]),
            ("largest jump where there should be none, relative to its allowance",
             c["largest_excess"]),
        ]),
    )


def _basis(report):
    b = report["basis"]
    rows = [
        ("sum of all functions differs from 1 by at most", b["sum_defect"]),
        ("of which the input's own functions", b.get("input_sum_defect")),
        ("smallest coefficient (not negative: all functions are >= 0)", b["smallest_value"]),
        ("largest jump of a function across a diagonal", b["diagonal_jump"]),
        ("largest jump of a function across the core's faces", b["core_jump"]),
    ]
    if b["rank_measured"]:
        for kind in ("inner", "surface"):
            text = "%s functions: smallest eigenvalue of the scaled mass matrix" % kind
            rows.append((text, b[kind + "_eigenvalue"]))
            rows.append(("its round-off; independent when above", b[kind + "_roundoff"]))
    else:
        rows.append(("linear independence", "not measured: too many functions"))
    return _section("Basis", _facts(rows))


def _certificate(report):
    c = report["certificate"]
    rows = [
        ("verdict", c["verdict"]),
        ("elements: proved positive", "%d of %d" % (c["n_positive"], c["n_elements"])),
        ("elements: not positive, undecided", "%d, %d" % (c["n_not_positive"], c["n_undecided"])),
        ("smallest proved bound of det J / product of mean edge lengths", c["smallest_bound"]),
        ("deepest subdivision", c["depth"]),
    ]
    if c["verdict"] != "positive":
        rows.append(("place", _place(c["point"])))
    for point in c["singular"]:
        rows.append(("the part itself is singular at", _place(point)))
    return _section(
        "Certificate",
        _facts(rows),
        _note("det J > 0 is proved by bounds that hold between all sample points, round-off "
              "included."),
    )


def _quality(report):
    q = report["quality"]
    rows = [
        ("worst scaled Jacobian", q["worst"]),
        ("at", _place(q["worst_point"])),
        ("best that any solid over these faces can have", q["bound"]),
        ("because of the shape at", _place(q["bound_point"])),
        ("worst / that bound", q["ratio"]),
        ("mean, best", "%s, %s" % (_number(q["mean"]), _number(q["best"]))),
        ("worst before improvement", q["start_worst"]),
    ]
    return _section("Quality", _facts(rows))


def _volume(report):
    conformity, volume = report["conformity"], report.get("volume")
    rows = [
        ("quadrature over the solid", conformity["volume"]),
        ("flux through the prepared boundary", conformity["flux"]),
        ("relative difference", _relative(conformity["volume"], conformity["flux"])),
    ]
    if volume:
        rows += [
            ("flux through the CAD kernel's surfaces", volume["flux"]),
            ("relative difference", volume["relative_difference"]),
            ("allowed", volume["allowed"]),
        ]
    shown = [(name, v if v is None else _number(v, 15 if v > 1e-3 else 3)) for name, v in rows]
    return _section("Volume", _facts(shown))


def _statistics(report):
    labels = (
        ("input_nodes", "input nodes"),
        ("input_elements", "input elements"),
        ("tmesh_nodes", "T-mesh nodes"),
        ("interior_extraordinary_nodes", "interior extraordinary nodes"),
        ("partial_extraordinary_nodes", "partial extraordinary nodes"),
        ("core_cells", "core cells"),
        ("n_functions", "functions"),
        ("n_inner", "of these inside"),
        ("bezier_elements", "Bezier elements"),
    )
    rows = [(label, report["statistics"][key]) for key, label in labels]
    statistics = report["statistics"]
    levels = statistics.get("core_cells_of_level", [])
    rows.append(("core cells by level", ", ".join(
        "%d: %d" % (level, n) for level, n in enumerate(levels) if n)))
    if statistics.get("analysis_suitable", True):
        rows.append(("cells that the closure added", "%d to %d" % (
            statistics.get("tmesh_cells", 0) - statistics.get("tmesh_cells_before_closure", 0),
            statistics.get("tmesh_cells_before_closure", 0))))
    else:
        rows.append(("closure", "off: a rational T-spline; see the defect of the sum"))
    quality = report["quality"]
    rows.append(("Jacobian (worst, best)",
                 "%s, %s" % (_number(quality["worst"], 3), _number(quality["best"], 3))))
    return _section("Statistics", _facts(rows))


def _options(report):
    options = report.get("options", {}).items()
    rows = [(k.replace("_", " "), v) for k, v in options if v and v != "default"]
    return _section("Options that differ from the default", _facts(rows)) if rows else ""


def _findings(report):
    rows = []
    for f in report.get("findings", []):
        if f["severity"] == "note" and f["stage"] in ("exactness", "volume"):
            continue  # these stand in sections of their own
        place = "" if f["point"] is None else _place(f["point"])
        measured = "" if f["measured"] is None else _number(f["measured"])
        allowed = "" if f["allowed"] is None else _number(f["allowed"])
        rows.append((f["severity"], f["where"], f["text"], place, measured, allowed))
    head = ("severity", "where", "what", "place", "measured", "allowed")
    return _section("Findings", _table(rows, head)) if rows else ""


def _timing(report):
    timing = report["timing"]
    rows = [(k, v) for k, v in timing.items() if k != "peak_memory_mib" and v is not None]
    rows = [(name, "%.3f s" % seconds) for name, seconds in rows]
    if timing["peak_memory_mib"] is not None:
        rows.append(("peak memory", "%.0f MiB" % timing["peak_memory_mib"]))
    return _section("Time and memory", _facts(rows))


SECTIONS = (_requirement, _preparation, _exactness, _continuity, _basis, _certificate, _quality,
            _volume, _statistics, _options, _findings, _timing)


# ---- page ----------------------------------------------------------------------------------------


def _figure(png, caption):
    data = base64.b64encode(png).decode("ascii")
    image = '<img alt="%s" src="data:image/png;base64,%s">' % (_text(caption), data)
    return "<figure>%s\n<figcaption>%s</figcaption></figure>" % (image, _text(caption))


def _pictures(solid, context):
    elements = picture.Elements.of(context, solid)
    view, corner = picture.choose_view(elements)
    captions = (
        (None, "From outside. Lines are the borders of the Bezier elements."),
        (corner, "Cut open along element faces: the layers under the faces and the core."),
    )
    parts = []
    for removed, caption in captions:
        memory = io.BytesIO()
        picture.draw(memory, elements, view, removed)
        parts.append(_figure(memory.getvalue(), caption))
    return "\n".join(parts)


def page(report, pictures, title):
    """The page as text; pictures: HTML of the figures."""
    parts = ["<!DOCTYPE html>", '<html lang="en"><head><meta charset="utf-8">']
    parts.append("<title>%s: solid T-spline</title>" % _text(title))
    parts.append("<style>%s</style></head><body>" % STYLE)
    parts.append("<h1>%s: solid T-spline</h1>" % _text(title))
    parts.append(_verdict(report))
    parts.append(pictures)
    parts += [section(report) for section in SECTIONS]
    parts.append("<footer>%s</footer>" % _note(
        "All lengths in the unit of the part. Written by tsolid %s." % binding.header.VERSION))
    parts.append("</body></html>\n")
    return "\n".join(parts)


def check_page(result, groups, headline):
    """The page of a check alone: rows as the panel has them."""
    title = "%s: check" % (result.name or "part")
    from . import rows

    kind = "good" if result.satisfied else "bad"
    parts = ["<!DOCTYPE html>", '<html lang="en"><head><meta charset="utf-8">']
    parts.append("<title>%s</title>" % _text(title))
    parts.append("<style>%s</style></head><body>" % STYLE)
    parts.append("<h1>%s</h1>" % _text(title))
    parts.append('<div class="verdict %s"><strong>%s</strong></div>' % (kind, _text(headline)))
    for group in groups:
        cells = [row.cells() + ("" if row.point is None else _place(row.point),)
                 for row in group.rows]
        parts.append(_section(group.title, _table(cells, rows.COLUMNS + ("place",))))
    parts.append("</body></html>\n")
    return "\n".join(parts)


def write_html(path, report, solid, title="", context=None):
    """Writes the page with pictures of the solid; the file appears complete or not at all."""
    text = page(report, _pictures(solid, context or binding.Context()), title)
    beside = path + ".part"
    try:
        with open(beside, "w", encoding="utf-8", errors="backslashreplace", newline="\n") as file:
            file.write(text)
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.unlink(beside)
        raise
