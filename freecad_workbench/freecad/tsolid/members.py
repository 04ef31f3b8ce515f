# SPDX-License-Identifier: LGPL-2.1-or-later
"""The solids of an assembly, each in its place: of documents (App::Part trees, Links, arrays of
Links, compounds) and of shapes as a STEP file gives them (compounds, compsolids).

A2plus and the Assembly workbenches keep their parts as objects with placements, or as Links in
groups: both are walked like any other tree.
"""


class Member:
    """One solid. shape: in its place; name: unique in the assembly; obj, path: the top object and
    the path below it that select it in the tree (None, "" without a document); first: the number of
    the member whose geometry this one shares (its own when it is the first), placed by
    `placement` relative to that geometry."""

    def __init__(self, name, shape, obj=None, path=""):
        self.name, self.shape = name, shape
        self.obj, self.path = obj, path
        self.first = None
        self.placement = shape.Placement

    def face(self, number):
        """FreeCAD's name of a face below `obj`."""
        return "%sFace%d" % (self.path, number + 1)


def of_shape(shape, name="Solid"):
    """The solids of a shape: of a compound or compsolid one by one."""
    solids = shape.Solids
    if len(solids) == 1:
        return _grouped([Member(name, solids[0])])
    return _grouped([Member("%s%d" % (name, k), s) for k, s in enumerate(solids, 1)])


def of_document(doc):
    """All solids that the document shows at its top, or below containers."""
    return of_objects([o for o in doc.Objects if not _parents(o)])


def of_objects(objects):
    """The solids of document objects; what has none is passed over."""
    found, names = [], set()
    for obj in objects:
        if obj.TypeId.startswith("App::Origin") or not _is_wanted(obj):
            continue
        for path, label, shape in _leaves(obj, "", obj.Label, 0):
            solids = shape.Solids
            for k, solid in enumerate(solids, 1):
                own = label if len(solids) == 1 else "%s.%d" % (label, k)
                found.append(Member(_unique(own, names), solid, obj, path))
    return _grouped(found)


def _is_wanted(obj):
    """Not what another solid is made of, as the features of a Body or the tools of a cut."""
    for user in obj.InList:
        if _is_container(user) or user.hasExtension("App::LinkBaseExtension"):
            continue
        if getattr(getattr(user, "Shape", None), "Solids", ()):
            return False
    return True


def _is_container(obj):
    return any(obj.isDerivedFrom(kind) for kind in
               ("App::Part", "App::DocumentObjectGroup", "App::LinkGroup"))


def _parents(obj):
    """Objects that stand for this one, too, so that it is not walked twice: containers, and arrays
    of Links that show their elements."""
    return [o for o in obj.InList
            if _is_container(o) or obj in getattr(o, "ElementList", ())]


MAX_DEPTH = 32


def _leaves(obj, path, label, depth):
    """(path, label, shape in place) of what has a shape of its own below an object."""
    top, inner = obj, obj.getSubObjectList(path)[-1] if path else obj
    linked = inner.getLinkedObject(True)
    below = inner.getSubObjects() if _is_tree(inner, linked) and depth < MAX_DEPTH else ()
    if below:
        for name in below:
            child = top.getSubObjectList(path + name)[-1]
            if child.TypeId.startswith("App::Origin") or not _is_wanted(child):
                continue
            own = label if child is inner else child.Label
            number = name.rstrip(".")
            if number.isdigit():  # an element of an array of Links
                own = "%s.%s" % (inner.Label, number)
            yield from _leaves(top, path + name, own, depth + 1)
        return
    shape = top.getSubObject(path) if path else getattr(obj, "Shape", None)
    if shape is not None and hasattr(shape, "Solids") and shape.Solids:
        yield path, label, shape


def _is_tree(inner, linked):
    """Whether an object stands for several: a container, a Link to one, an array of Links."""
    if _is_container(inner) or _is_container(linked):
        return True
    return bool(getattr(inner, "ElementCount", 0))


def _unique(name, names):
    """The name, with a number when it is taken."""
    own, k = name, 2
    while own in names:
        own, k = "%s (%d)" % (name, k), k + 1
    names.add(own)
    return own


def _grouped(members):
    """Finds the members that share one geometry and differ by their placements only."""
    firsts = []
    for k, member in enumerate(members):
        same = (f for f in firsts if members[f].shape.isPartner(member.shape))
        member.first = next(same, k)
        if member.first == k:
            firsts.append(k)
    return members
