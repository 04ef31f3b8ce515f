# SPDX-License-Identifier: LGPL-2.1-or-later
"""From a FreeCAD shape to NURBS patches and back.

Taken: one solid whose faces are B-splines, or exactly convertible to them, and whose trims all run
along isoparametric lines. Everything else is refused with FreeCAD's names (Face3, Edge7, Vertex2).
"""

import collections
import random

import FreeCAD
import Part

from .binding import Patch, Refused, finding
from .header import Severity, Status

TOLERANCE = 1e-7  # OCC's own confusion distance; edges may carry more
MAX_DEGREE = 25
N_SAMPLES = 1000
SEED = 20120713

Source = collections.namedtuple("Source", "name patch surface box sign kind deviation")
Source.__doc__ = """One face of the input.

surface is OCC's B-spline as read (or as converted), box the part of it that the face covers, patch
the same as knots and control points, sign -1 where the face looks against the surface's normal
(0: not known), kind the type as read, deviation the largest distance that conversion caused."""


def refuse(where, text, **numbers):
    raise Refused(Status.ERROR_REFUSED, [_error(where, text, **numbers)])


def _error(where, text, **numbers):
    return finding(Severity.ERROR, "shape", where, text, **numbers)


class Names:
    """FreeCAD's names of the sub-shapes of a shape."""

    def __init__(self, shape):
        self._pools = {"Edge": {}, "Vertex": {}}
        self.edges = shape.Edges
        for word, items in (("Edge", self.edges), ("Vertex", shape.Vertexes)):
            for number, item in enumerate(items, 1):
                self._pools[word].setdefault(item.hashCode(), []).append((number, item))

    def of(self, word, item):
        for number, known in self._pools[word].get(item.hashCode(), ()):
            if known.isSame(item):
                return "%s%d" % (word, number)
        return ""

    def edge(self, item):
        return self.of("Edge", item)

    def vertex(self, item):
        return self.of("Vertex", item)


# ---- the solid -------------------------------------------------------------------------------


def _free_edges(shape, names):
    """Edges that only one face uses (once): name and a point of each."""
    count = collections.Counter()
    items = {}
    for face in shape.Faces:
        for wire in face.Wires:
            for edge in wire.Edges:
                if not edge.Degenerated:
                    name = names.edge(edge)
                    count[name] += 1
                    items[name] = edge
    free = [n for n in items if count[n] == 1 and not _is_seam_somewhere(shape, items[n])]
    return [(n, items[n].valueAt(sum(items[n].ParameterRange) / 2)) for n in free]


def _is_seam_somewhere(shape, edge):
    return any(edge.isSeam(face) for face in shape.Faces)


def the_solid(shape):
    """The one solid of a shape; Refused when there is none, more than one, or a void in it."""
    if shape is None or shape.isNull():
        refuse("", "the shape is empty")
    solids = shape.Solids
    if not solids:
        _refuse_no_solid(shape)
    if len(solids) > 1:
        parts = ", ".join("Solid%d" % (i + 1) for i in range(len(solids)))
        refuse(parts, "the shape holds %d solids; take one at a time" % len(solids))
    solid = solids[0]
    loose = len(shape.Faces) - len(solid.Faces)
    if loose:
        refuse("", "%d faces of the shape do not belong to its solid" % loose)
    if len(solid.Shells) != 1:
        refuse("", "the solid has a void inside: it is bounded by %d shells" % len(solid.Shells))
    return solid


def _refuse_no_solid(shape):
    if not shape.Faces:
        refuse("", "not a solid: the shape (%s) has no faces" % shape.ShapeType)
    free = _free_edges(shape, Names(shape))
    if not free:
        refuse(
            "",
            "not a solid but a closed surface (%s): make a solid of it first (Part, Convert to "
            "solid)" % shape.ShapeType,
        )
    raise Refused(
        Status.ERROR_REFUSED,
        [
            _error(name, "not a solid: the surface is open along this edge", point=point)
            for name, point in free
        ],
    )


# ---- one face --------------------------------------------------------------------------------


class _Trim:
    """The rectangle of a face in its surface's parameters, with the edges along each border.

    Borders are in the order v low, u high, v high, u low.
    """

    def __init__(self, face, edge_name, vertex_name):
        self.face = face
        self.edge_name = edge_name
        self.vertex_name = vertex_name
        self.surface = face.Surface
        self.problems = []
        self.edges = [[], [], [], []]
        self.box = self._snapped()
        for edge in face.OuterWire.Edges:
            self._place(edge)
        if not self.problems and not all(self.edges):
            self.problems.append(("", "a border of the face has no edge", None))

    def _problem(self, edge, text):
        point = edge.valueAt(sum(edge.ParameterRange) / 2)
        self.problems.append((self.edge_name(edge), text, point))

    def _snapped(self):
        """The face's parameter range, snapped to knots that are the same point."""
        resolution = self.surface.getResolution(TOLERANCE)
        knots = (self.surface.getUKnots(), self.surface.getVKnots())
        box = list(self.face.ParameterRange)
        for i in range(4):
            near = min(knots[i // 2], key=lambda k: abs(k - box[i]))
            if abs(near - box[i]) <= resolution[i // 2]:
                box[i] = near
        return tuple(box)

    def _place(self, edge):
        if edge.Degenerated:
            point = edge.Vertexes[0].Point
            where = self.vertex_name(point)
            self.problems.append((where, "a border shrinks to a single point (a pole)", point))
            return
        if edge.isSeam(self.face):
            self._problem(edge, "the face closes on itself along this edge (a seam)")
            return
        given = self.face.curveOnSurface(edge)
        if given is None:
            self._problem(edge, "the edge has no curve on the surface")
            return
        border = self._border(edge, *given[:3])
        if border is None:
            self._problem(edge, "trimmed along a curve that is not an isoparametric line")
        else:
            self.edges[border].append(edge)

    def _border(self, edge, curve, first, last):
        tolerance = self.surface.getResolution(max(TOLERANCE, edge.Tolerance))
        points = [curve.value(first + (last - first) * i / 32.0) for i in range(33)]
        if isinstance(curve, Part.Geom2d.BSplineCurve2d):
            whole = first <= curve.FirstParameter and curve.LastParameter <= last
            points += curve.getPoles() if whole else []
        u0, u1, v0, v1 = self.box
        for border, axis, value in ((0, 1, v0), (1, 0, u1), (2, 1, v1), (3, 0, u0)):
            if all(abs((p.x, p.y)[axis] - value) <= tolerance[axis] for p in points):
                return border
        return None


def _along(edge, others):
    """The edge of `others` that runs where `edge` does: for faces that conversion has rebuilt."""
    first, last = edge.ParameterRange
    points = [edge.valueAt(first + (last - first) * x) for x in (0.21, 0.5, 0.83)]
    best, worst = None, None
    for other in others:
        if other.Degenerated:
            continue
        far = max(Part.Vertex(p).distToShape(other)[0] for p in points)
        if worst is None or far < worst:
            best, worst = other, far
    return best if worst is not None and worst <= max(TOLERANCE, best.Tolerance) else None


def _as_bspline(face):
    """The face on a B-spline surface; the very face where it is one already."""
    if isinstance(face.Surface, Part.BSplineSurface):
        return face
    # cleaned(): OCC >= 7.7 corrupts toNurbs() of a shape that carries triangles
    return face.cleaned().toNurbs().Faces[0]


def _conversion_deviation(original, surface, box):
    """Largest distance of the converted surface from the one as read, at N_SAMPLES points."""
    numbers = random.Random(SEED)
    u0, u1, v0, v1 = box
    worst = 0.0
    for _ in range(N_SAMPLES):
        point = surface.value(numbers.uniform(u0, u1), numbers.uniform(v0, v1))
        worst = max(worst, (original.value(*original.parameter(point)) - point).Length)
    return worst


def _is_clamped(surface):
    for knots, degree in (
        (surface.UKnotSequence, surface.UDegree),
        (surface.VKnotSequence, surface.VDegree),
    ):
        if knots[0] != knots[degree] or knots[-1] != knots[-1 - degree]:
            return False
    return not surface.isUPeriodic() and not surface.isVPeriodic()


def _segmented(surface, box):
    """The surface on the box alone, clamped at its ends: exact knot insertion."""
    own = surface.copy()
    if tuple(own.bounds()) != tuple(box) or not _is_clamped(own):
        own.segment(*box)
    return own


def patch_of_surface(surface, **names):
    """Knots, control points and weights of a clamped B-spline surface."""
    poles = surface.getPoles()
    n, m = len(poles), len(poles[0])
    weights = None
    if surface.isURational() or surface.isVRational():
        rows = surface.getWeights()
        weights = [rows[i][j] for j in range(m) for i in range(n)]
    points = [(poles[i][j].x, poles[i][j].y, poles[i][j].z) for j in range(m) for i in range(n)]
    degree = (surface.UDegree, surface.VDegree)
    knots = (surface.UKnotSequence, surface.VKnotSequence)
    return Patch(degree, (n, m), knots, points, weights, **names)


class _FaceNames:
    """Names of edges and vertices of one face; by place where conversion has rebuilt them."""

    def __init__(self, face, names):
        self.originals = face.OuterWire.Edges
        self.vertexes = face.Vertexes
        self.names = names

    def original(self, edge):
        if any(edge.isSame(x) for x in self.originals):
            return edge
        return _along(edge, self.originals)

    def edge(self, edge):
        own = self.original(edge)
        return self.names.edge(own) if own is not None else ""

    def vertex(self, point):
        nearest = min(self.vertexes, key=lambda x: (x.Point - point).Length)
        near = (nearest.Point - point).Length <= max(TOLERANCE, nearest.Tolerance)
        return self.names.vertex(nearest) if near else ""

    def border(self, edges):
        return ", ".join(filter(None, map(self.edge, edges)))

    def tolerance(self, edges):
        """The largest tolerance of the edges along a border, as the input has them."""
        return max((self.original(e) or e).Tolerance for e in edges)


def _source(face, name, names):
    """One face as a Source; or the list of findings that refuse it."""
    if len(face.Wires) != 1:
        holes = len(face.Wires) - 1
        text = "the face has %d hole%s" % (holes, "" if holes == 1 else "s")
        return [_error(name, text, point=face.CenterOfMass)]
    if face.Area <= 0.0:
        return [_error(name, "the face has no area")]
    kind, deviation = type(face.Surface).__name__, 0.0
    try:
        converted = _as_bspline(face)
        if converted is not face:
            box = converted.ParameterRange
            deviation = _conversion_deviation(face.Surface, converted.Surface, box)
    except (Part.OCCError, IndexError, TypeError) as error:
        return [_error(name, "%s cannot be re-written as a B-spline (%s)" % (kind, error))]
    if not deviation <= TOLERANCE:
        text = "%s has no exact B-spline form: re-writing it changes it" % kind
        return [_error(name, text, measured=deviation, allowed=TOLERANCE)]
    own = _FaceNames(face, names)
    trim = _Trim(converted, own.edge, own.vertex)
    if trim.problems:
        return [
            _error("%s, %s" % (name, where) if where else name, text, point=point)
            for where, text, point in trim.problems
        ]
    surface = trim.surface
    segment = _segmented(surface, trim.box)
    if max(segment.UDegree, segment.VDegree) > MAX_DEGREE:
        return [_error(name, "degree above %d" % MAX_DEGREE)]
    u0, u1, v0, v1 = trim.box
    corners = ((u0, v0), (u1, v0), (u1, v1), (u0, v1))
    patch = patch_of_surface(
        segment,
        name=name,
        border_names=[own.border(edges) for edges in trim.edges],
        corner_names=[own.vertex(surface.value(u, v)) for u, v in corners],
        border_tolerance=[own.tolerance(edges) for edges in trim.edges],
    )
    sign = -1 if converted.Orientation == "Reversed" else 1
    return Source(name, patch, surface, trim.box, sign, kind, deviation)


# ---- the whole shape -------------------------------------------------------------------------


def _missing(problems, n_faces):
    """What a part with seams or poles lacks, in one sentence."""
    words = []
    for mark, text in (("(a seam)", "closing on themselves"), ("(a pole)", "shrinking to a point")):
        faces = sorted({p.where.split(",")[0] for p in problems if mark in p.text})
        if faces:
            words.append("%s: %s" % (text, ", ".join(faces)))
    return (
        "the solid has %d face%s (%s); missing are eight corners where three edges meet and the "
        "twelve edges between them: cut its surface into six four-sided sides"
        % (n_faces, "" if n_faces == 1 else "s", "; ".join(words))
    )


def sources_of_shape(shape, tell=None):
    """The faces of the shape's one solid, in FreeCAD's order, and notes about conversions.

    tell(fraction), if given, is called before every face; what it raises ends the work.
    """
    the_solid(shape)
    names = Names(shape)
    sources, problems = [], []
    for number, face in enumerate(shape.Faces, 1):
        if tell is not None:
            tell((number - 1) / len(shape.Faces))
        given = _source(face, "Face%d" % number, names)
        if isinstance(given, Source):
            sources.append(given)
        else:
            problems += given
    if problems:
        if any(mark in p.text for p in problems for mark in ("(a seam)", "(a pole)")):
            problems.insert(0, _error("", _missing(problems, len(shape.Faces))))
        raise Refused(Status.ERROR_REFUSED, problems)
    return sources, [_note(s, shape) for s in sources if s.kind != "BSplineSurface"]


def _note(source, shape):
    allowed = 1e-12 * scale_of_shape(shape)
    exact = source.deviation <= allowed
    return finding(
        Severity.NOTE if exact else Severity.WARNING,
        "shape",
        source.name,
        "%s re-written as a B-spline%s" % (source.kind, ", exactly" if exact else ""),
        measured=source.deviation,
        allowed=allowed,
    )


def scale_of_shape(shape):
    """The larger of the bounding box's diagonal and the largest |coordinate|."""
    box = shape.BoundBox
    limits = (box.XMin, box.XMax, box.YMin, box.YMax, box.ZMin, box.ZMax)
    return max([box.DiagonalLength] + [abs(x) for x in limits])


# ---- and back --------------------------------------------------------------------------------


def _distinct(knots):
    values, counts = [], []
    for knot in knots:
        if values and knot == values[-1]:
            counts[-1] += 1
        else:
            values.append(knot)
            counts.append(1)
    return values, counts


def surface_of_patch(patch):
    """The patch as a Part.BSplineSurface."""
    n, m = patch.n_control
    poles = [[FreeCAD.Vector(*patch.points[i + n * j]) for j in range(m)] for i in range(n)]
    (u, u_counts), (v, v_counts) = _distinct(patch.knots[0]), _distinct(patch.knots[1])
    arguments = [poles, u_counts, v_counts, u, v, False, False, patch.degree[0], patch.degree[1]]
    if patch.weights is not None:
        arguments.append([[patch.weights[i + n * j] for j in range(m)] for i in range(n)])
    surface = Part.BSplineSurface()
    surface.buildFromPolesMultsKnots(*arguments)
    return surface


def source_of_patch(patch, number):
    """A Source of a patch that no shape stands behind, so that it can be measured like a face."""
    surface = surface_of_patch(patch)
    name = patch.name or "patch %d" % number
    return Source(name, patch, surface, surface.bounds(), 0, "BSplineSurface", 0.0)


def patches_of_boundary(boundary):
    """The boundary's Bezier elements as patches of one span each."""
    points = boundary.points
    out = []
    for side in range(6):
        degree = boundary.side_degree(side)
        size = (degree[0] + 1) * (degree[1] + 1)
        for element in boundary.elements(side):
            net = [[0.0] * 4 for _ in range(size)]
            for function, row in zip(element.functions, element.coefficients):
                point = [points[function, d] for d in range(4)]
                for net_row, c in zip(net, row):
                    for d in range(4):
                        net_row[d] += c * point[d]
            out.append(_bezier_patch(degree, net, "side %d" % side))
    return out


def _bezier_patch(degree, net, name):
    knots = [[0.0] * (p + 1) + [1.0] * (p + 1) for p in degree]
    points = [(x / w, y / w, z / w) for x, y, z, w in net]
    weights = [row[3] for row in net]
    same = all(w == weights[0] for w in weights)
    n_control = (degree[0] + 1, degree[1] + 1)
    return Patch(degree, n_control, knots, points, None if same else weights, name=name)


def solid_of_faces(faces):
    """A closed valid solid made of loose faces; Refused when they do not close."""
    compound = Part.makeCompound(faces)
    compound.sewShape(1e-6)  # OCC takes 1e-6 whatever is said here
    if len(compound.Shells) != 1 or not compound.Shells[0].isClosed():
        refuse("", "the patches do not close to one shell")
    solid = Part.makeSolid(compound.Shells[0])
    if solid.Volume < 0:
        solid.reverse()
    return solid


def solid_of_patches(patches):
    return solid_of_faces([surface_of_patch(p).toShape() for p in patches])
