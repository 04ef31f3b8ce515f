# SPDX-License-Identifier: LGPL-2.1-or-later
"""The solids of an assembly, each in its place: of documents (App::Part trees, Links, arrays of
Links, compounds) and of shapes as a STEP file gives them (compounds, compsolids).

A2plus and the Assembly workbenches keep their parts as objects with placements, or as Links in
groups: both are walked like any other tree.
"""


MAX_DEPTH = 32


class Member:
    """One solid. shape: in its place; name: unique in the assembly; obj, path: the top object and
    the path below it that select it in the tree (None, "" without a document); first: the number of
    the member whose geometry this one shares (its own when it is the first), placed by
    `placement` relative to that geometry; first_face: how many faces of the object come before."""

    def __init__(self, name, shape, obj=None, path="", first_face=0):
        self.name, self.shape = name, shape
        self.obj, self.path = obj, path
        self.first_face = first_face
        self.first = None
        self.placement = shape.Placement

    def below(self, face):
        """The name below `obj` that selects a face of this solid ("": the solid itself)."""
        return self.path + self.of_object(face)

    def of_object(self, face):
        """The face's name in the object, which may hold several solids."""
        return "Face%d" % (self.first_face + int(face[4:])) if face else ""


def of_shape(shape, name="Solid"):
    """The solids of a shape: of a compound or compsolid one by one."""
    solids = shape.Solids
    if len(solids) == 1:
        return _grouped([Member(name, solids[0])])
    return _grouped([Member("%s%d" % (name, k), s) for k, s in enumerate(solids, 1)])


def of_document(doc):
    """All solids that the document shows at its top, or below containers."""
    return of_objects(top_objects(doc))


def top_objects(doc):
    """The objects of a document that are not below others."""
    return [o for o in doc.Objects if not _parents(o)]


def of_objects(objects):
    """The solids of document objects, where their containers put them; what has none is passed
    over."""
    found, names = [], set()
    for inner in objects:
        if inner.TypeId.startswith("App::Origin") or not _is_wanted(inner):
            continue
        obj, start = _place_in_tree(inner)
        for path, label, shape in _leaves(obj, start, inner.Label, 0):
            solids = shape.Solids
            first_face = 0
            for k, solid in enumerate(solids, 1):
                own = label if len(solids) == 1 else "%s.%d" % (label, k)
                found.append(Member(_unique(own, names), solid, obj, path, first_face))
                first_face += len(solid.Faces)
    return _grouped(found)


def _place_in_tree(obj):
    """(top, path) of an object inside containers, which may be moved; (itself, "") else."""
    path, depth = "", 0
    while depth < MAX_DEPTH:
        above = [o for o in _parents(obj) if _is_container(o)]
        if not above:
            break
        path, obj, depth = "%s.%s" % (obj.Name, path), above[0], depth + 1
    return obj, path


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
