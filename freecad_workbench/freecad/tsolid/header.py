# SPDX-License-Identifier: LGPL-2.1-or-later
"""Mirror of tsolid.h for ctypes: version, enums, structs and prototypes, in the header's order.

Opaque handles are plain addresses (c_void_p). tests/test_binding.py compares every line here
with the header; library.py compares the sizes with the library that was found.
"""

import ctypes
import enum
from ctypes import POINTER, c_char, c_char_p, c_double, c_int, c_size_t, c_void_p

VERSION = "0.1.0"
ABI = 1


# An enumerator's name is the header's without "TSOLID_".


class Status(enum.IntEnum):
    OK = 0
    ERROR_MEMORY = 1
    ERROR_ARGUMENT = 2
    ERROR_INPUT = 3
    ERROR_REFUSED = 4
    ERROR_IO = 5
    ERROR_CANCELLED = 6
    ERROR_NUMERIC = 7
    ERROR_INTERNAL = 8


class Severity(enum.IntEnum):
    NOTE = 0
    WARNING = 1
    ERROR = 2


class Entity(enum.IntEnum):
    ENTITY_NONE = 0
    ENTITY_PATCH = 1
    ENTITY_BORDER = 2
    ENTITY_VERTEX = 3
    ENTITY_SIDE = 4
    ENTITY_ISOLINE = 5
    ENTITY_CORNER = 6
    ENTITY_ELEMENT = 7
    ENTITY_FUNCTION = 8
    ENTITY_LINE = 9
    ENTITY_SURFACE_VERTEX = 10


class Verdict(enum.IntEnum):
    POSITIVE = 0
    NOT_POSITIVE = 1
    UNDECIDED = 2


class CoonsRepair(enum.IntEnum):
    REPAIR_AUTOMATIC = 0
    REPAIR_NEVER = 1
    REPAIR_ALWAYS = 2


class Contact(enum.IntEnum):
    CONTACT_EXACT = 0
    CONTACT_GEOMETRIC = 1
    CONTACT_PARTIAL = 2
    CONTACT_COINCIDENT = 3
    CONTACT_NEAR = 4


class ClashKind(enum.IntEnum):
    CLASH_OVERLAP = 0
    CLASH_INSIDE = 1
    CLASH_TWICE = 2
    CLASH_SELF = 3


class AssemblyVerdict(enum.IntEnum):
    ASSEMBLY_WATERTIGHT = 0
    ASSEMBLY_GAPS = 1
    ASSEMBLY_CLASHES = 2
    ASSEMBLY_INCOMPLETE = 3


class MatrixKind(enum.IntEnum):
    MASS = 0
    LAPLACE = 1
    ELASTICITY = 2


ENUMS = {
    "tsolid_status": Status,
    "tsolid_severity": Severity,
    "tsolid_entity": Entity,
    "tsolid_coons_repair": CoonsRepair,
    "tsolid_verdict": Verdict,
    "tsolid_contact": Contact,
    "tsolid_clash_kind": ClashKind,
    "tsolid_assembly_verdict": AssemblyVerdict,
    "tsolid_matrix_kind": MatrixKind,
}

ALLOCATE = ctypes.CFUNCTYPE(c_void_p, c_void_p, c_size_t)
RELEASE = ctypes.CFUNCTYPE(None, c_void_p, c_void_p)
PROGRESS = ctypes.CFUNCTYPE(c_int, c_void_p, c_char_p, c_double)

CALLBACKS = {
    "tsolid_allocate_fn": ALLOCATE,
    "tsolid_release_fn": RELEASE,
    "tsolid_progress_fn": PROGRESS,
}

_ints = POINTER(c_int)
_doubles = POINTER(c_double)


class FindingStruct(ctypes.Structure):
    _fields_ = [
        ("severity", c_int),
        ("status", c_int),
        ("entity", c_int),
        ("index", c_int * 2),
        ("has_point", c_int),
        ("point", c_double * 3),
        ("measured", c_double),
        ("allowed", c_double),
        ("stage", c_char_p),
        ("text", c_char_p),
    ]


class ContextOptions(ctypes.Structure):
    _fields_ = [
        ("allocate", ALLOCATE),
        ("release", RELEASE),
        ("allocator_data", c_void_p),
        ("progress", PROGRESS),
        ("progress_data", c_void_p),
        ("n_threads", c_int),
    ]


class SurfaceView(ctypes.Structure):
    _fields_ = [
        ("n_faces", c_int),
        ("n_edges", c_int),
        ("n_vertices", c_int),
        ("n_points", c_int),
        ("n_t_junctions", c_int),
        ("n_boundary_loops", c_int),
        ("n_boundary_edges", c_int),
        ("n_parts", c_int),
        ("n_extraordinary", c_int),
        ("extraordinary", _ints),
        ("valence", _ints),
        ("sum_defect", c_double),
        ("points", _doubles),
        ("face_size", _doubles),
        ("element_start", _ints),
        ("degree", c_int),
        ("n_elements", c_int),
        ("box", _doubles),
        ("function_start", _ints),
        ("function", _ints),
        ("coefficient", _doubles),
    ]


class BezierSide(ctypes.Structure):
    _fields_ = [
        ("degree", c_int * 2),
        ("n_elements", c_int),
        ("box", _doubles),
        ("function_start", _ints),
        ("function", _ints),
        ("coefficient", _doubles),
    ]


class Tspline(ctypes.Structure):
    _fields_ = [
        ("degree", c_int * 2),
        ("n_functions", c_int),
        ("point", _ints),
        ("knots", _doubles * 2),
        ("domain", c_double * 4),
    ]


class PatchStruct(ctypes.Structure):
    _fields_ = [
        ("degree", c_int * 2),
        ("n_control", c_int * 2),
        ("knots", _doubles * 2),
        ("points", _doubles),
        ("weights", _doubles),
        ("name", c_char_p),
        ("border_name", c_char_p * 4),
        ("corner_name", c_char_p * 4),
        ("border_tolerance", c_double * 4),
        ("tspline", POINTER(Tspline)),
        ("bezier", POINTER(BezierSide)),
        ("fixed", c_int),
    ]


class SmoothSeam(ctypes.Structure):
    _fields_ = [
        ("patch", c_int * 2),
        ("border", c_int * 2),
        ("order", c_int),
    ]


class BezierBoundary(ctypes.Structure):
    _fields_ = [
        ("n_functions", c_int),
        ("points", _doubles),
        ("side", BezierSide * 6),
    ]


class BoundaryInput(ctypes.Structure):
    _fields_ = [
        ("n_patches", c_int),
        ("patches", POINTER(PatchStruct)),
        ("bezier", POINTER(BezierBoundary)),
        ("surface", c_void_p),
        ("n_points", c_int),
        ("points", _doubles),
        ("n_smooth", c_int),
        ("smooth", POINTER(SmoothSeam)),
    ]


class BoundaryOptions(ctypes.Structure):
    _fields_ = [
        ("tolerance", c_double),
        ("refine_knots", c_int),
        ("raise_degree", c_int),
        ("n_corners", c_int),
        ("corners", _doubles),
    ]


class Requirement(ctypes.Structure):
    _fields_ = [
        ("satisfied", c_int),
        ("closed", c_int),
        ("connected", c_int),
        ("genus", c_int),
        ("n_patches", c_int),
        ("n_vertices", c_int),
        ("n_edges", c_int),
        ("n_extraordinary", c_int),
        ("n_violations", c_int),
        ("corner", (c_double * 3) * 8),
        ("side_grid", (c_int * 2) * 6),
        ("corner_name", (c_char * 64) * 8),
    ]


class Preparation(ctypes.Structure):
    _fields_ = [
        ("snap", c_double * 12),
        ("snap_inside", c_double * 6),
        ("weight_factor", c_double * 6),
        ("knot_merge", c_double),
        ("n_knots_inserted", c_int),
        ("n_degrees_raised", c_int),
        ("refine_knots", c_int),
        ("raise_degree", c_int),
        ("n_bilinear_factors", c_int),
        ("n_moebius", c_int),
        ("n_cut_patches", c_int),
        ("n_cuts", c_int),
        ("n_knots_merged", c_int),
    ]


class Placement(ctypes.Structure):
    _fields_ = [
        ("side", c_int),
        ("swap", c_int),
        ("flip", c_int * 2),
        ("box", c_double * 4),
        ("domain", c_double * 4),
        ("moebius", c_double * 2),
    ]


class Curve(ctypes.Structure):
    _fields_ = [
        ("degree", c_int),
        ("n_control", c_int),
        ("knots", _doubles),
        ("points", _doubles),
        ("weights", _doubles),
        ("name", c_char_p),
    ]


class CoonsOptions(ctypes.Structure):
    _fields_ = [
        ("tolerance", c_double),
        ("normal", c_double * 3),
        ("name", c_char_p),
        ("corner_name", c_char_p * 4),
        ("repair", c_int),
    ]


class CoonsReport(ctypes.Structure):
    _fields_ = [
        ("origin", c_double * 3),
        ("normal", c_double * 3),
        ("plane_distance", c_double),
        ("corner_gap", c_double),
        ("knot_merge", c_double),
        ("weight_factor", c_double * 4),
        ("linear_border", c_int),
        ("linear_factor", c_double * 2),
        ("n_degrees_raised", c_int),
        ("n_knots_inserted", c_int),
        ("weights_replaced", c_int),
        ("repaired", c_int),
        ("n_inside_degrees", c_int),
        ("n_inside_knots", c_int),
        ("start_worst", c_double),
        ("worst", c_double),
        ("bound", c_double),
        ("worst_point", c_double * 3),
        ("area", c_double),
        ("n_elements", c_int),
        ("depth", c_int),
        ("n_singular", c_int),
        ("singular", (c_double * 3) * 4),
    ]


class TmeshOptions(ctypes.Structure):
    _fields_ = [
        ("min_cells", c_int),
        ("isotropic", c_int),
        ("analysis_suitable_off", c_int),
        ("sharp_core", c_int),
    ]


class TmeshView(ctypes.Structure):
    _fields_ = [
        ("n_planes", c_int * 3),
        ("plane_value", _doubles * 3),
        ("core_plane", (c_int * 2) * 3),
        ("n_cells", c_int),
        ("cell", _ints),
        ("cell_block", _ints),
        ("arm_height", c_double * 6),
        ("n_nodes", c_int),
        ("n_partial_extraordinary", c_int),
        ("n_extraordinary", c_int),
    ]


class SpaceView(ctypes.Structure):
    _fields_ = [
        ("n_functions", c_int),
        ("n_inner", c_int),
        ("n_surface", c_int),
        ("n_elements", c_int),
        ("element_block", _ints),
        ("element_degree", _ints),
        ("element_box", _doubles),
    ]


class SolidOptions(ctypes.Structure):
    _fields_ = [("effort", c_int)]


class CertificateOptions(ctypes.Structure):
    _fields_ = [("max_depth", c_int)]


class CertificateStruct(ctypes.Structure):
    _fields_ = [
        ("verdict", c_int),
        ("n_elements", c_int),
        ("n_positive", c_int),
        ("n_not_positive", c_int),
        ("n_undecided", c_int),
        ("n_singular", c_int),
        ("singular", (c_double * 3) * 8),
        ("depth", c_int),
        ("element", c_int),
        ("u", c_double * 3),
        ("point", c_double * 3),
        ("smallest_bound", c_double),
    ]


class Quality(ctypes.Structure):
    _fields_ = [
        ("worst", c_double),
        ("mean", c_double),
        ("best", c_double),
        ("worst_element", c_int),
        ("worst_u", c_double * 3),
        ("worst_point", c_double * 3),
        ("start_worst", c_double),
        ("bound", c_double),
        ("bound_point", c_double * 3),
        ("ratio", c_double),
    ]


class BasisReport(ctypes.Structure):
    _fields_ = [
        ("sum_defect", c_double),
        ("input_sum_defect", c_double),
        ("smallest_value", c_double),
        ("rank_measured", c_int),
        ("inner_eigenvalue", c_double),
        ("surface_eigenvalue", c_double),
        ("inner_roundoff", c_double),
        ("surface_roundoff", c_double),
        ("diagonal_jump", c_double),
        ("core_jump", c_double),
    ]


class ContinuityReport(ctypes.Structure):
    _fields_ = [
        ("area", c_double * 4),
        ("n_faces", c_int),
        ("n_below_expected", c_int),
        ("largest_excess", c_double),
    ]


class ConformityReport(ctypes.Structure):
    _fields_ = [
        ("n_samples", c_int),
        ("distance", c_double),
        ("scale", c_double),
        ("control_identical", c_int),
        ("volume", c_double),
        ("flux", c_double),
    ]


class Statistics(ctypes.Structure):
    _fields_ = [
        ("input_nodes", c_int),
        ("input_elements", c_int),
        ("tmesh_nodes", c_int),
        ("interior_extraordinary_nodes", c_int),
        ("partial_extraordinary_nodes", c_int),
        ("core_cells", c_int),
        ("n_functions", c_int),
        ("n_inner", c_int),
        ("bezier_elements", c_int),
        ("core_cells_of_level", c_int * 24),
        ("analysis_suitable", c_int),
        ("tmesh_cells", c_int),
        ("tmesh_cells_before_closure", c_int),
    ]


class Timing(ctypes.Structure):
    _fields_ = [
        ("boundary", c_double),
        ("tmesh", c_double),
        ("space", c_double),
        ("start", c_double),
        ("optimise", c_double),
        ("certify", c_double),
        ("report", c_double),
        ("total", c_double),
        ("peak_memory_mib", c_double),
    ]


class ReportStruct(ctypes.Structure):
    _fields_ = [
        ("requirement", Requirement),
        ("preparation", Preparation),
        ("statistics", Statistics),
        ("conformity", ConformityReport),
        ("basis", BasisReport),
        ("continuity", ContinuityReport),
        ("certificate", CertificateStruct),
        ("quality", Quality),
        ("timing", Timing),
    ]


class ReportOptions(ctypes.Structure):
    _fields_ = [("max_rank_functions", c_int)]


class PartStruct(ctypes.Structure):
    _fields_ = [
        ("name", c_char_p),
        ("boundary", POINTER(BoundaryInput)),
        ("placement", _doubles),
    ]


class AssemblyInput(ctypes.Structure):
    _fields_ = [("n_parts", c_int), ("parts", POINTER(PartStruct))]


class AssemblyOptions(ctypes.Structure):
    _fields_ = [("tolerance", c_double), ("gap", c_double)]


class InterfaceStruct(ctypes.Structure):
    _fields_ = [
        ("kind", c_int),
        ("part", c_int * 2),
        ("patch", c_int * 2),
        ("same_side", c_int),
        ("code", c_int),
        ("box", (c_double * 4) * 2),
        ("moebius", c_double * 2),
        ("deviation", c_double),
        ("gap", c_double),
        ("smallest_gap", c_double),
        ("depth", c_double),
        ("point", c_double * 3),
        ("area", c_double),
        ("same_functions", c_int),
        ("same_bits", c_int),
        ("gap_after", c_double),
        ("ulp_after", c_double),
        ("continuity", c_int * 2),
    ]


class ClashStruct(ctypes.Structure):
    _fields_ = [
        ("kind", c_int),
        ("part", c_int * 2),
        ("patch", c_int * 2),
        ("depth", c_double),
        ("point", c_double * 3),
    ]


class PartFacts(ctypes.Structure):
    _fields_ = [
        ("name", c_char_p),
        ("status", c_int),
        ("n_patches", c_int),
        ("n_free", c_int),
        ("n_interfaces", c_int),
        ("copy_of", c_int),
        ("closed", c_int),
        ("volume", c_double),
        ("area", c_double),
    ]


class FreeFace(ctypes.Structure):
    _fields_ = [
        ("part", c_int),
        ("patch", c_int),
        ("area", c_double),
        ("fraction", c_double),
    ]


class AssemblyView(ctypes.Structure):
    _fields_ = [
        ("n_parts", c_int),
        ("n_patches", c_int),
        ("part", POINTER(PartFacts)),
        ("n_interfaces", c_int),
        ("interface", POINTER(InterfaceStruct)),
        ("n_clashes", c_int),
        ("clash", POINTER(ClashStruct)),
        ("n_free", c_int),
        ("free_face", POINTER(FreeFace)),
        ("n_of_kind", c_int * 5),
        ("n_groups", c_int),
        ("gap", c_double),
        ("volume", c_double),
        ("volume_inside", c_double),
        ("verdict", c_int),
    ]


class RegionStruct(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("side", c_int), ("box", c_double * 4)]


class HexOptions(ctypes.Structure):
    _fields_ = [
        ("order", c_int),
        ("size", c_double),
        ("divisions", c_int * 4),
        ("grading", c_double),
        ("max_elements", c_int),
        ("allow_unproved", c_int),
        ("n_regions", c_int),
        ("regions", POINTER(RegionStruct)),
    ]


class HexView(ctypes.Structure):
    _fields_ = [
        ("order", c_int),
        ("divisions", c_int * 4),
        ("n_nodes", c_int),
        ("nodes", _doubles),
        ("n_elements", c_int),
        ("nodes_per_element", c_int),
        ("element", _ints),
        ("n_regions", c_int),
        ("region_name", POINTER(c_char_p)),
        ("region_start", _ints),
        ("region_face", _ints),
        ("worst", c_double),
        ("worst_element", c_int),
        ("proved", c_int),
        ("n_parts", c_int),
        ("part_name", POINTER(c_char_p)),
        ("part_start", _ints),
        ("n_shared", c_int),
    ]


class HexPart(ctypes.Structure):
    _fields_ = [
        ("divisions", c_int * 4),
        ("n_regions", c_int),
        ("regions", POINTER(RegionStruct)),
    ]


class FieldStruct(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("n_components", c_int), ("coefficient", _doubles)]


class BextOptions(ctypes.Structure):
    _fields_ = [
        ("n_regions", c_int),
        ("regions", POINTER(RegionStruct)),
        ("allow_unproved", c_int),
    ]


class BextView(ctypes.Structure):
    _fields_ = [
        ("patch", c_int),
        ("rational", c_int),
        ("n_nodes", c_int),
        ("nodes", _doubles),
        ("control", _doubles),
        ("n_elements", c_int),
        ("degree", _ints),
        ("function_start", _ints),
        ("function", _ints),
        ("vector", _ints),
        ("n_vectors", c_int),
        ("vector_start", _ints),
        ("coefficient", _doubles),
    ]


class Material(ctypes.Structure):
    _fields_ = [("young", c_double), ("poisson", c_double)]


class MatrixView(ctypes.Structure):
    _fields_ = [
        ("n_rows", c_int),
        ("n_components", c_int),
        ("row_start", POINTER(c_size_t)),
        ("column", _ints),
        ("value", _doubles),
    ]


STRUCTS = {
    "tsolid_finding": FindingStruct,
    "tsolid_context_options": ContextOptions,
    "tsolid_surface_view": SurfaceView,
    "tsolid_bezier_side": BezierSide,
    "tsolid_tspline": Tspline,
    "tsolid_patch": PatchStruct,
    "tsolid_smooth_seam": SmoothSeam,
    "tsolid_bezier_boundary": BezierBoundary,
    "tsolid_boundary_input": BoundaryInput,
    "tsolid_boundary_options": BoundaryOptions,
    "tsolid_requirement": Requirement,
    "tsolid_preparation": Preparation,
    "tsolid_placement": Placement,
    "tsolid_curve": Curve,
    "tsolid_coons_options": CoonsOptions,
    "tsolid_coons_report": CoonsReport,
    "tsolid_tmesh_options": TmeshOptions,
    "tsolid_tmesh_view": TmeshView,
    "tsolid_space_view": SpaceView,
    "tsolid_solid_options": SolidOptions,
    "tsolid_certificate_options": CertificateOptions,
    "tsolid_certificate": CertificateStruct,
    "tsolid_quality": Quality,
    "tsolid_basis_report": BasisReport,
    "tsolid_continuity_report": ContinuityReport,
    "tsolid_conformity_report": ConformityReport,
    "tsolid_statistics": Statistics,
    "tsolid_timing": Timing,
    "tsolid_report": ReportStruct,
    "tsolid_report_options": ReportOptions,
    "tsolid_part": PartStruct,
    "tsolid_assembly_input": AssemblyInput,
    "tsolid_assembly_options": AssemblyOptions,
    "tsolid_interface": InterfaceStruct,
    "tsolid_clash": ClashStruct,
    "tsolid_part_facts": PartFacts,
    "tsolid_free_face": FreeFace,
    "tsolid_assembly_view": AssemblyView,
    "tsolid_region": RegionStruct,
    "tsolid_hex_options": HexOptions,
    "tsolid_hex_view": HexView,
    "tsolid_hex_part": HexPart,
    "tsolid_field": FieldStruct,
    "tsolid_bext_options": BextOptions,
    "tsolid_bext_view": BextView,
    "tsolid_material": Material,
    "tsolid_matrix_view": MatrixView,
}

OPAQUE = (
    "tsolid_context",
    "tsolid_surface",
    "tsolid_boundary_file",
    "tsolid_boundary",
    "tsolid_coons",
    "tsolid_tmesh",
    "tsolid_space",
    "tsolid_solid",
    "tsolid_assembly",
    "tsolid_hex",
    "tsolid_bext",
    "tsolid_matrix",
)

_handle = c_void_p
_handle_out = POINTER(c_void_p)

# name: (result, arguments)
FUNCTIONS = {
    "tsolid_version": (c_char_p, []),
    "tsolid_abi": (c_int, []),
    "tsolid_struct_size": (c_size_t, [c_char_p]),
    "tsolid_context_create": (c_int, [POINTER(ContextOptions), _handle_out]),
    "tsolid_context_free": (None, [_handle]),
    "tsolid_context_n_findings": (c_int, [_handle]),
    "tsolid_context_finding": (POINTER(FindingStruct), [_handle, c_int]),
    "tsolid_context_clear": (None, [_handle]),
    "tsolid_release": (None, [_handle, c_void_p]),
    "tsolid_read_tsm": (c_int, [_handle, c_char_p, _handle_out]),
    "tsolid_write_tsm": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_read_iga": (c_int, [_handle, c_char_p, _handle_out]),
    "tsolid_surface_free": (None, [_handle]),
    "tsolid_surface_get": (None, [_handle, POINTER(SurfaceView)]),
    "tsolid_surface_evaluate": (
        c_int,
        [_handle, _handle, c_int, c_double, c_double, c_int, _doubles],
    ),
    "tsolid_surface_patches": (c_int, [_handle, _handle, _handle_out]),
    "tsolid_boundary_create": (
        c_int,
        [
            _handle,
            POINTER(BoundaryInput),
            POINTER(BoundaryOptions),
            POINTER(Requirement),
            _handle_out,
        ],
    ),
    "tsolid_boundary_free": (None, [_handle]),
    "tsolid_boundary_view": (None, [_handle, POINTER(BezierBoundary)]),
    "tsolid_boundary_requirement": (None, [_handle, POINTER(Requirement)]),
    "tsolid_boundary_preparation": (None, [_handle, POINTER(Preparation)]),
    "tsolid_boundary_n_placements": (c_int, [_handle, c_int]),
    "tsolid_boundary_placement": (c_int, [_handle, c_int, c_int, POINTER(Placement)]),
    "tsolid_boundary_scale": (c_double, [_handle]),
    "tsolid_coons_create": (
        c_int,
        [_handle, POINTER(Curve), POINTER(CoonsOptions), POINTER(CoonsReport), _handle_out],
    ),
    "tsolid_coons_free": (None, [_handle]),
    "tsolid_coons_get": (None, [_handle, POINTER(PatchStruct)]),
    "tsolid_tmesh_create": (c_int, [_handle, _handle, POINTER(TmeshOptions), _handle_out]),
    "tsolid_tmesh_free": (None, [_handle]),
    "tsolid_tmesh_get": (None, [_handle, POINTER(TmeshView)]),
    "tsolid_space_create": (c_int, [_handle, _handle, _handle, _handle_out]),
    "tsolid_space_free": (None, [_handle]),
    "tsolid_space_get": (None, [_handle, POINTER(SpaceView)]),
    "tsolid_space_boundary": (_handle, [_handle]),
    "tsolid_space_tmesh": (_handle, [_handle]),
    "tsolid_space_extraction": (c_int, [_handle, _handle, c_int, c_int, _ints, _ints, _doubles]),
    "tsolid_solid_create": (c_int, [_handle, _handle, _handle_out]),
    "tsolid_solid_optimise": (c_int, [_handle, _handle, POINTER(SolidOptions), _handle_out]),
    "tsolid_solid_from_control": (c_int, [_handle, _handle, _doubles, _handle_out]),
    "tsolid_solid_free": (None, [_handle]),
    "tsolid_solid_space": (_handle, [_handle]),
    "tsolid_solid_control": (_doubles, [_handle]),
    "tsolid_solid_bezier": (c_int, [_handle, _handle, c_int, _doubles]),
    "tsolid_solid_evaluate": (c_int, [_handle, _handle, c_int, _doubles, c_int, _doubles]),
    "tsolid_solid_boundary_point": (c_int, [_handle, c_int, c_double, c_double, _doubles]),
    "tsolid_solid_invert": (
        c_int,
        [_handle, _handle, _doubles, c_double, _ints, _ints, _doubles, _doubles],
    ),
    "tsolid_certify": (
        c_int,
        [_handle, _handle, POINTER(CertificateOptions), POINTER(CertificateStruct), _ints],
    ),
    "tsolid_certify_element": (
        c_int,
        [_handle, _ints, _doubles, POINTER(CertificateOptions), POINTER(CertificateStruct)],
    ),
    "tsolid_quality_measure": (c_int, [_handle, _handle, POINTER(Quality)]),
    "tsolid_report_measure": (
        c_int,
        [_handle, _handle, POINTER(ReportOptions), POINTER(ReportStruct)],
    ),
    "tsolid_report_json": (c_int, [_handle, POINTER(ReportStruct), POINTER(c_char_p)]),
    "tsolid_read_tsb": (c_int, [_handle, c_char_p, _handle_out]),
    "tsolid_boundary_file_input": (POINTER(BoundaryInput), [_handle]),
    "tsolid_boundary_file_free": (None, [_handle]),
    "tsolid_write_tsb": (c_int, [_handle, POINTER(BoundaryInput), c_char_p]),
    "tsolid_write_tsolid": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_read_tsolid": (c_int, [_handle, c_char_p, _handle_out]),
    "tsolid_write_svg": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_write_vtu": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_assembly_create": (
        c_int,
        [_handle, POINTER(AssemblyInput), POINTER(AssemblyOptions), _handle_out],
    ),
    "tsolid_assembly_free": (None, [_handle]),
    "tsolid_assembly_get": (None, [_handle, POINTER(AssemblyView)]),
    "tsolid_assembly_boundary_input": (POINTER(BoundaryInput), [_handle, c_int]),
    "tsolid_assembly_join": (
        c_int,
        [_handle, _handle, c_int, _handle_out, _handle_out],
    ),
    "tsolid_assembly_evaluate": (
        c_int,
        [_handle, _handle, c_int, c_int, c_double, c_double, _doubles],
    ),
    "tsolid_assembly_json": (c_int, [_handle, _handle, POINTER(c_char_p)]),
    "tsolid_hex_create": (c_int, [_handle, _handle, POINTER(HexOptions), _handle_out]),
    "tsolid_hex_assembly_create": (
        c_int,
        [
            _handle,
            _handle,
            c_int,
            POINTER(_handle),
            POINTER(HexPart),
            POINTER(HexOptions),
            _handle_out,
        ],
    ),
    "tsolid_hex_free": (None, [_handle]),
    "tsolid_hex_get": (None, [_handle, POINTER(HexView)]),
    "tsolid_write_vtu_fields": (
        c_int,
        [_handle, _handle, c_int, POINTER(FieldStruct), c_char_p],
    ),
    "tsolid_write_inp": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_write_hex_vtu": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_write_bext": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_write_bext_sets": (c_int, [_handle, _handle, POINTER(BextOptions), c_char_p]),
    "tsolid_write_extraction": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_read_bext": (c_int, [_handle, c_char_p, _handle_out]),
    "tsolid_bext_free": (None, [_handle]),
    "tsolid_bext_get": (None, [_handle, POINTER(BextView)]),
    "tsolid_matrix_create": (c_int, [_handle, _handle, c_int, POINTER(Material), _handle_out]),
    "tsolid_matrix_free": (None, [_handle]),
    "tsolid_matrix_get": (None, [_handle, POINTER(MatrixView)]),
    "tsolid_face_load": (c_int, [_handle, _handle, POINTER(RegionStruct), _doubles]),
    "tsolid_face_functions": (
        c_int,
        [_handle, _handle, POINTER(RegionStruct), c_int, _ints, _ints],
    ),
    "tsolid_write_matrix_market": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_write_petsc": (c_int, [_handle, _handle, c_char_p]),
    "tsolid_write_vector_market": (c_int, [_handle, c_int, _doubles, c_char_p]),
    "tsolid_write_vector_petsc": (c_int, [_handle, c_int, _doubles, c_char_p]),
    "tsolid_write_table_market": (c_int, [_handle, c_int, c_int, _doubles, c_char_p]),
    "tsolid_write_set_petsc": (c_int, [_handle, c_int, _ints, c_char_p]),
    "tsolid_read_table": (c_int, [_handle, c_char_p, _ints, _ints, POINTER(_doubles)]),
}
