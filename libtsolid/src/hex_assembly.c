/* SPDX-License-Identifier: LGPL-2.1-or-later
 * One mesh of an assembly.
 *
 * Every part is meshed on the lines that all agree on (hex_assembly_lines.c). A bond is a rectangle
 * of lattice points on both sides, the same number each way: point (i, j) of the one is point (i,
 * j) of the other, and their nodes become one. Which nodes are one is so told by numbers alone;
 * their coordinates, computed from either part, may differ by what rounding leaves, and those of
 * the part that comes first are taken. Nodes where several parts meet follow by transitivity. */
#include <stdlib.h>

#include "boundary.h"
#include "hex_assembly.h"

static const char stage[] = "hexahedra";

/* Of the assembly's size: how far apart two nodes that become one may be computed. Mid nodes are
 * found by halving, each part from its own end of the line: of the line's length. */
static const double corner_resolution = 1e-9, mid_resolution = 1e-3;

enum { DEFAULT_MAX_ELEMENTS = 2000000, MOST_DIVISIONS = 1000000, NAME_ROOM = 16 };

typedef struct mesh_part {
  const double *placement; /* NULL: none */
  tsolid_hex *hex;
  int *surface; /* nodes of the outermost layer by lattice point */
  size_t n[3];  /* lattice points */
  int first_node, first_element;
} mesh_part;

typedef struct assembler {
  tsolid_context *context;
  tsi_arena *arena;
  const tsolid_assembly *assembly;
  int n_parts, n_bonds, order;
  const tsolid_solid *const *solid;
  tsi_hex_member *member;
  mesh_part *part;
  tsi_bond *bond;
  int n_nodes, n_elements;
  int *same;              /* a smaller node that a node is one with, or itself */
  unsigned char *covered; /* outer elements whose face lies on a bond: 2: of its first part */
  double scale;
  tsolid_hex *hex;
} assembler;

/* ---- bonds -------------------------------------------------------------------------------------
 */

static void tell_open_contacts(const assembler *a, int n_open, int first) {
  if (!n_open)
    return;
  const tsolid_interface *view = &a->assembly->contact[first].view;
  tsolid_finding finding = tsi_finding(TSOLID_WARNING, TSOLID_OK, stage);
  tsi_report(a->context, &finding,
             "%d of %d contacts are not bonded, parts have nodes of their own there: %s and %s "
             "have not the same functions where they meet",
             n_open, a->assembly->n_contacts, a->member[view->part[0]].name,
             a->member[view->part[1]].name);
}

static tsolid_status collect_bonds(assembler *a) {
  int n_open = 0, first = -1, capacity = 0;
  for (int k = 0; k < a->assembly->n_contacts; k++) {
    const tsolid_interface *view = &a->assembly->contact[k].view;
    int n = 0;
    tsi_bond *list = NULL;
    if (tsi_is_watertight(view) && view->same_functions == 1) {
      tsolid_status status =
          tsi_contact_bonds(a->context, a->arena, a->assembly, k, a->solid, &n, &list);
      if (status)
        return status;
    }
    first = n == 0 && first < 0 ? k : first;
    n_open += n == 0;
    if (a->n_bonds + n > capacity) {
      capacity = 2 * (a->n_bonds + n);
      tsi_bond *more = tsi_arena_new(a->arena, (size_t)capacity, sizeof *more);
      if (!more)
        return tsi_no_memory(a->context, stage);
      if (a->n_bonds)
        memcpy(more, a->bond, (size_t)a->n_bonds * sizeof *more);
      a->bond = more;
    }
    if (n)
      memcpy(a->bond + a->n_bonds, list, (size_t)n * sizeof *list);
    a->n_bonds += n;
  }
  tell_open_contacts(a, n_open, first);
  return TSOLID_OK;
}

/* ---- the parts' own meshes ---------------------------------------------------------------------
 */

static tsolid_status count_elements(const assembler *a, int max_elements) {
  double n = 0.0, most = max_elements ? max_elements : DEFAULT_MAX_ELEMENTS;
  for (int k = 0; k < a->n_parts; k++) {
    const int *d = a->member[k].lines.n;
    double x = d[0], y = d[1], z = d[2];
    n += x * y * z + 2.0 * d[3] * (x * y + y * z + z * x);
  }
  if (!(n <= most) || n > TSI_MAX_COUNT)
    return tsi_fail(a->context, TSOLID_ERROR_REFUSED, stage,
                    "The %d parts would have %.0f elements, more than %.0f: take a larger size",
                    a->n_parts, n, most);
  return TSOLID_OK;
}

static tsolid_status mesh_parts(assembler *a) {
  for (int k = 0; k < a->n_parts; k++) {
    mesh_part *part = &a->part[k];
    const tsi_hex_member *member = &a->member[k];
    tsolid_status status = tsi_hex_build(a->context, a->arena, member->solid, &member->options,
                                         &member->lines, &part->surface, &part->hex);
    if (status)
      return status;
    for (int i = 0; part->placement && i < part->hex->n_nodes; i++)
      tsi_place_point(part->placement, part->hex->nodes + 3 * (size_t)i);
    for (int d = 0; d < 3; d++)
      part->n[d] = (size_t)(a->order * member->lines.n[d] + 1);
    part->first_node = a->n_nodes;
    part->first_element = a->n_elements;
    if (a->n_nodes > TSI_MAX_COUNT - part->hex->n_nodes)
      return tsi_fail(a->context, TSOLID_ERROR_REFUSED, stage, "The mesh has too many nodes");
    a->n_nodes += part->hex->n_nodes;
    a->n_elements += part->hex->n_elements;
    for (size_t i = 0; i < 3 * (size_t)part->hex->n_nodes; i++)
      a->scale = fmax(a->scale, fabs(part->hex->nodes[i]));
  }
  return TSOLID_OK;
}

/* ---- shared nodes ------------------------------------------------------------------------------
 */

static int find_node(const int *same, int k) {
  while (same[k] != k)
    k = same[k];
  return k;
}

static void unite_nodes(int *same, int a, int b) {
  a = find_node(same, a);
  b = find_node(same, b);
  same[a > b ? a : b] = a > b ? b : a;
}

/* Number of the corner line of an axis nearest to x, which is one up to rounding. */
static int find_line(const tsi_hex_lines *lines, int axis, double x) {
  const double *at = lines->x[axis];
  int low = 0, high = lines->n[axis], order = lines->order;
  while (low < high) {
    int middle = (low + high) / 2;
    if (0.5 * (at[order * middle] + at[order * (middle + 1)]) < x)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* A bond in lattice cells: direction k goes from cell line low[i][k] of part i by step[i][k], n[k]
 * cells. */
typedef struct patch_of_cells {
  int low[2][2], step[2][2], n[2];
} patch_of_cells;

static int find_cells(const assembler *a, const tsi_bond *bond, patch_of_cells *p) {
  int n[2][2];
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++) {
      const tsi_hex_lines *lines = &a->member[bond->part[i]].lines;
      int axis = bond->axis[i][k], end = find_line(lines, axis, bond->to[i][k]);
      p->low[i][k] = find_line(lines, axis, bond->from[i][k]);
      p->step[i][k] = end < p->low[i][k] ? -1 : 1;
      n[i][k] = abs(end - p->low[i][k]);
    }
  memcpy(p->n, n[0], sizeof p->n);
  return n[0][0] == n[1][0] && n[0][1] == n[1][1];
}

/* The node of lattice point (i, j), in halves of cells where the order is 2, on side k; -1: none */
static int bond_node(const assembler *a, const tsi_bond *bond, const patch_of_cells *p, int k,
                     int i, int j) {
  const mesh_part *part = &a->part[bond->part[k]];
  int side = bond->side[k], normal = tsi_side_axis(side), at[2] = {i, j};
  size_t x[3];
  x[normal] = side & 1 ? part->n[normal] - 1 : 0;
  for (int d = 0; d < 2; d++)
    x[bond->axis[k][d]] = (size_t)(a->order * p->low[k][d] + p->step[k][d] * at[d]);
  int node = part->surface[tsi_lattice_id(part->n, x)];
  return node < 0 ? -1 : part->first_node + node;
}

static const double *node_point(const assembler *a, const tsi_bond *bond, int k, int node) {
  const mesh_part *part = &a->part[bond->part[k]];
  return part->hex->nodes + 3 * (size_t)(node - part->first_node);
}

/* How far apart the nodes of lattice point (i, j) may be: mid nodes by the length of their line. */
static double allowed(const assembler *a, const tsi_bond *bond, const patch_of_cells *p, int i,
                      int j) {
  int d[2] = {a->order == 2 && i & 1, a->order == 2 && j & 1};
  double limit = corner_resolution * a->scale;
  if (!d[0] && !d[1])
    return limit;
  int low = bond_node(a, bond, p, 0, i - d[0], j - d[1]),
      high = bond_node(a, bond, p, 0, i + d[0], j + d[1]);
  return limit +
         mid_resolution * tsi_distance(node_point(a, bond, 0, low), node_point(a, bond, 0, high));
}

static tsolid_status share_bond(assembler *a, const tsi_bond *bond) {
  patch_of_cells p;
  double worst = find_cells(a, bond, &p) ? 0.0 : INFINITY;
  for (int j = 0; worst <= 0.0 && j <= a->order * p.n[1]; j++)
    for (int i = 0; i <= a->order * p.n[0]; i++) {
      int node[2] = {bond_node(a, bond, &p, 0, i, j), bond_node(a, bond, &p, 1, i, j)};
      if (node[0] < 0 || node[1] < 0)
        continue;
      double off = tsi_distance(node_point(a, bond, 0, node[0]), node_point(a, bond, 1, node[1]));
      if (!(off <= allowed(a, bond, &p, i, j)))
        worst = fmax(worst, off);
      unite_nodes(a->same, node[0], node[1]);
    }
  if (worst > 0.0)
    return tsi_fail(a->context, TSOLID_ERROR_INTERNAL, stage,
                    "Nodes of %s and %s that should be one are %.3g apart",
                    a->member[bond->part[0]].name, a->member[bond->part[1]].name, worst);
  for (int k = 0; k < 2; k++)
    for (int j = 0; j < p.n[1]; j++)
      for (int i = 0; i < p.n[0]; i++) {
        const mesh_part *part = &a->part[bond->part[k]];
        const tsi_hex_lines *lines = &a->member[bond->part[k]].lines;
        int side = bond->side[k], at[3] = {0}, cell[2] = {i, j};
        for (int d = 0; d < 2; d++)
          at[bond->axis[k][d]] = p.low[k][d] + p.step[k][d] * cell[d] - (p.step[k][d] < 0);
        int element = tsi_hex_first_outer(lines, side) + at[tsi_side_s(side)] +
                      lines->n[tsi_side_s(side)] * at[tsi_side_t(side)];
        a->covered[part->first_element + element] = (unsigned char)(k ? 1 : 2);
      }
  return TSOLID_OK;
}

static tsolid_status share_nodes(assembler *a) {
  a->same = tsi_arena_new(a->arena, (size_t)a->n_nodes, sizeof *a->same);
  a->covered = tsi_arena_new(a->arena, (size_t)a->n_elements, 1);
  if (!a->same || !a->covered)
    return tsi_no_memory(a->context, stage);
  for (int k = 0; k < a->n_nodes; k++)
    a->same[k] = k;
  for (int k = 0; k < a->n_bonds; k++) {
    tsolid_status status = share_bond(a, &a->bond[k]);
    if (!status)
      status = tsi_progress(a->context, stage, 0.7 + 0.3 * k / a->n_bonds);
    if (status)
      return status;
  }
  return TSOLID_OK;
}

/* ---- one mesh ----------------------------------------------------------------------------------
 */

static tsolid_status put_together(assembler *a) {
  tsolid_hex *hex = a->hex;
  size_t width = (size_t)tsi_hex_width(a->order);
  int *number = tsi_arena_new(a->arena, (size_t)a->n_nodes, sizeof *number);
  for (int k = 0; number && k < a->n_nodes; k++)
    number[k] = a->same[k] == k ? hex->n_nodes++ : number[find_node(a->same, k)];
  hex->order = a->order;
  hex->n_elements = a->n_elements;
  hex->n_parts = a->n_parts;
  hex->n_shared = a->n_nodes - hex->n_nodes;
  hex->nodes = tsi_new(&hex->allocator, (size_t)hex->n_nodes, 3 * sizeof *hex->nodes);
  hex->element = tsi_new(&hex->allocator, (size_t)a->n_elements, width * sizeof *hex->element);
  hex->part_start = tsi_new(&hex->allocator, (size_t)a->n_parts + 1, sizeof *hex->part_start);
  if (!number || !hex->nodes || !hex->element || !hex->part_start)
    return tsi_no_memory(a->context, stage);
  for (int p = 0; p < a->n_parts; p++) {
    const mesh_part *part = &a->part[p];
    for (int k = 0; k < part->hex->n_nodes; k++)
      if (a->same[part->first_node + k] == part->first_node + k)
        memcpy(hex->nodes + 3 * (size_t)number[part->first_node + k],
               part->hex->nodes + 3 * (size_t)k, 3 * sizeof *hex->nodes);
    int *to = hex->element + (size_t)part->first_element * width;
    for (size_t i = 0; i < (size_t)part->hex->n_elements * width; i++)
      to[i] = number[part->first_node + part->hex->element[i]];
    hex->part_start[p + 1] = part->first_element + part->hex->n_elements;
  }
  return TSOLID_OK;
}

/* ---- names -------------------------------------------------------------------------------------
 */

static int same_letters(const char *a, const char *b) {
  for (;; a++, b++) {
    int x = *a >= 'a' && *a <= 'z' ? *a - 'a' + 'A' : *a;
    int y = *b >= 'a' && *b <= 'z' ? *b - 'a' + 'A' : *b;
    if (x != y || !x)
      return x == y;
  }
}

static int is_taken(const tsolid_hex *hex, int n, const char *name) {
  int found = same_letters(name, "Eall");
  for (int k = 0; k < n && !found; k++)
    found = same_letters(hex->part_name[k], name);
  return found;
}

static size_t print_number(int n, char *text) {
  char digits[NAME_ROOM];
  size_t count = 0, length = 0;
  do
    digits[count++] = (char)('0' + n % 10);
  while ((n /= 10) > 0);
  text[length++] = '_';
  while (count)
    text[length++] = digits[--count];
  text[length] = 0;
  return length;
}

/* Names that occur again get a number: wheel, wheel_2. */
static tsolid_status name_parts(assembler *a) {
  tsolid_hex *hex = a->hex;
  size_t length = 0;
  for (int k = 0; k < a->n_parts; k++)
    length += strlen(a->member[k].name) + NAME_ROOM;
  hex->part_names = tsi_new(&hex->allocator, length, 1);
  hex->part_name = tsi_new(&hex->allocator, (size_t)a->n_parts, sizeof *hex->part_name);
  if (!hex->part_names || !hex->part_name)
    return tsi_no_memory(a->context, stage);
  char *to = hex->part_names;
  for (int k = 0; k < a->n_parts; k++) {
    size_t own = strlen(a->member[k].name), all = own;
    memcpy(to, a->member[k].name, own + 1);
    for (int n = 2; is_taken(hex, k, to); n++)
      all = own + print_number(n, to + own);
    hex->part_name[k] = to;
    to += all + 1;
  }
  return TSOLID_OK;
}

/* ---- regions -----------------------------------------------------------------------------------
 */

/* A region of the whole: of part[0], its number there; or the contact of two parts. */
typedef struct named_set {
  int part[2], region;
  int n_faces;
} named_set;

static int compare_sets(const void *x, const void *y) {
  const named_set *a = x, *b = y;
  int d = a->part[0] != b->part[0] ? a->part[0] - b->part[0] : a->part[1] - b->part[1];
  return (d > 0) - (d < 0);
}

/* Pairs of parts that a bond joins, each once, ascending. */
static int list_pairs(const assembler *a, named_set *set) {
  int n = 0;
  for (int k = 0; k < a->n_bonds; k++)
    set[k] = (named_set){{a->bond[k].part[0], a->bond[k].part[1]}, -1, 0};
  qsort(set, (size_t)a->n_bonds, sizeof *set, compare_sets);
  for (int k = 0; k < a->n_bonds; k++)
    if (k == 0 || compare_sets(&set[k], &set[n - 1]) != 0)
      set[n++] = set[k];
  return n;
}

static int find_pair(const named_set *set, int n, const int part[2]) {
  named_set key = {{part[0], part[1]}, -1, 0};
  const named_set *found = bsearch(&key, set, (size_t)n, sizeof *set, compare_sets);
  return found ? (int)(found - set) : -1;
}

/* Element and face of every cell of a bond on its first part, to `to` unless NULL. */
static int list_bond(const assembler *a, const tsi_bond *bond, int *to) {
  static const int face_number[3][2] = {{5, 3}, {2, 4}, {0, 1}};
  patch_of_cells p;
  int side = bond->side[0], n = 0;
  const tsi_hex_lines *lines = &a->member[bond->part[0]].lines;
  find_cells(a, bond, &p);
  for (int j = 0; to && j < p.n[1]; j++)
    for (int i = 0; i < p.n[0]; i++, n++) {
      int at[3] = {0}, cell[2] = {i, j};
      for (int d = 0; d < 2; d++)
        at[bond->axis[0][d]] = p.low[0][d] + p.step[0][d] * cell[d] - (p.step[0][d] < 0);
      to[2 * n] = a->part[bond->part[0]].first_element + tsi_hex_first_outer(lines, side) +
                  at[tsi_side_s(side)] + lines->n[tsi_side_s(side)] * at[tsi_side_t(side)];
      to[2 * n + 1] = face_number[tsi_side_axis(side)][side & 1];
    }
  return p.n[0] * p.n[1];
}

/* Free faces of a part's region, to `to` unless NULL. */
static int list_free(const assembler *a, const named_set *set, int *to) {
  const mesh_part *part = &a->part[set->part[0]];
  const tsolid_hex *hex = part->hex;
  int n = 0;
  for (int k = hex->region_start[set->region]; k < hex->region_start[set->region + 1]; k++) {
    int element = part->first_element + hex->region_face[2 * k];
    if (a->covered[element])
      continue;
    if (to) {
      to[2 * n] = element;
      to[2 * n + 1] = hex->region_face[2 * k + 1];
    }
    n++;
  }
  return n;
}

static size_t name_set(const assembler *a, const named_set *set, char *to) {
  const char *piece[5] = {"contact_", a->hex->part_name[set->part[0]], "_", NULL, NULL};
  size_t length = 0;
  if (set->region < 0)
    piece[3] = a->hex->part_name[set->part[1]];
  else
    piece[3] = a->part[set->part[0]].hex->region_name[set->region];
  for (int k = set->region < 0 ? 0 : 1; piece[k]; k++) {
    size_t n = strlen(piece[k]);
    if (to)
      memcpy(to + length, piece[k], n + 1);
    length += n;
  }
  return length + 1;
}

static tsolid_status put_regions(assembler *a, const named_set *set, int n_sets, int n_pairs) {
  tsolid_hex *hex = a->hex;
  size_t length = 0;
  int n_faces = 0;
  for (int k = 0; k < n_sets; k++) {
    length += name_set(a, &set[k], NULL);
    n_faces += set[k].n_faces;
  }
  hex->names = tsi_new(&hex->allocator, length, 1);
  hex->region_name = tsi_new(&hex->allocator, (size_t)n_sets, sizeof *hex->region_name);
  hex->region_start = tsi_new(&hex->allocator, (size_t)n_sets + 1, sizeof *hex->region_start);
  hex->region_face = tsi_new(&hex->allocator, (size_t)n_faces, 2 * sizeof *hex->region_face);
  int *next = tsi_arena_new(a->arena, (size_t)n_sets, sizeof *next);
  if (!hex->names || !hex->region_name || !hex->region_start || !hex->region_face || !next)
    return tsi_no_memory(a->context, stage);
  char *to = hex->names;
  hex->n_regions = n_sets;
  for (int k = 0; k < n_sets; k++) {
    hex->region_name[k] = to;
    to += name_set(a, &set[k], to);
    next[k] = hex->region_start[k];
    hex->region_start[k + 1] = hex->region_start[k] + set[k].n_faces;
    if (set[k].region >= 0)
      list_free(a, &set[k], hex->region_face + 2 * next[k]);
  }
  int first = n_sets - n_pairs;
  for (int k = 0; k < a->n_bonds; k++) {
    int pair = first + find_pair(set + first, n_pairs, a->bond[k].part);
    next[pair] += list_bond(a, &a->bond[k], hex->region_face + 2 * next[pair]);
  }
  return TSOLID_OK;
}

static tsolid_status make_regions(assembler *a) {
  size_t most = 0;
  int n = 0;
  for (int p = 0; p < a->n_parts; p++)
    most += (size_t)a->part[p].hex->n_regions;
  named_set *set = tsi_arena_new(a->arena, most + (size_t)a->n_bonds, sizeof *set);
  if (!set)
    return tsi_no_memory(a->context, stage);
  for (int p = 0; p < a->n_parts; p++)
    for (int k = 0; k < a->part[p].hex->n_regions; k++) {
      set[n] = (named_set){{p, p}, k, 0};
      set[n].n_faces = list_free(a, &set[n], NULL);
      n += set[n].n_faces > 0;
    }
  named_set *pair = set + n;
  int n_pairs = list_pairs(a, pair);
  for (int k = 0; k < a->n_bonds; k++)
    pair[find_pair(pair, n_pairs, a->bond[k].part)].n_faces += list_bond(a, &a->bond[k], NULL);
  return put_regions(a, set, n + n_pairs, n_pairs);
}

/* ---- driver ------------------------------------------------------------------------------------
 */

static double largest_diagonal(const assembler *a) {
  double most = 0.0;
  for (int k = 0; k < a->n_parts; k++)
    most = fmax(most, tsi_hex_diagonal(a->solid[k]->space->boundary));
  return most;
}

/* Names, solids, options and proofs of all parts; copies are proved once. */
static tsolid_status open_parts(assembler *a, const tsolid_hex_part *part,
                                const tsolid_hex_options *options) {
  a->hex->proved = 1;
  for (int k = 0; k < a->n_parts; k++) {
    tsi_hex_member *member = &a->member[k];
    const tsi_member *from = &a->assembly->part[k];
    *member = (tsi_hex_member){.name = from->name, .solid = a->solid[k], .options = *options};
    a->part[k].placement = from->placed ? from->placement : NULL;
    if (!member->solid)
      return tsi_fail(a->context, TSOLID_ERROR_REFUSED, stage,
                      "There is no solid of %s, so no mesh of the whole", member->name);
    if (part) {
      memcpy(member->options.divisions, part[k].divisions, sizeof member->options.divisions);
      member->options.n_regions = part[k].n_regions;
      member->options.regions = part[k].regions;
    }
    for (int d = 0; d < 4; d++)
      if (member->options.divisions[d] > MOST_DIVISIONS)
        return tsi_fail(a->context, TSOLID_ERROR_REFUSED, stage, "%d divisions of %s are too many",
                        member->options.divisions[d], member->name);
    tsolid_status status = tsi_hex_check_options(a->context, &member->options);
    int first = 0, proved = 1;
    while (a->solid[first] != a->solid[k])
      first++;
    if (!status && first == k)
      status = tsi_hex_check_proof(a->context, member->solid, options, &proved);
    if (status)
      return status;
    a->hex->proved &= proved;
  }
  double size = options->size > 0.0 ? options->size : largest_diagonal(a) / 20.0;
  for (int k = 0; k < a->n_parts; k++)
    a->member[k].options.size = size;
  return TSOLID_OK;
}

static tsolid_status assemble(assembler *a, const tsolid_hex_part *part,
                              const tsolid_hex_options *options) {
  a->part = tsi_arena_new(a->arena, (size_t)a->n_parts, sizeof *a->part);
  a->member = tsi_arena_new(a->arena, (size_t)a->n_parts, sizeof *a->member);
  a->hex = tsi_hex_new(a->context);
  if (!a->part || !a->member || !a->hex)
    return tsi_no_memory(a->context, stage);
  tsolid_status status = open_parts(a, part, options);
  if (!status)
    status = collect_bonds(a);
  if (!status)
    status =
        tsi_hex_assembly_lines(a->context, a->arena, a->n_parts, a->member, a->n_bonds, a->bond);
  if (!status)
    status = count_elements(a, options->max_elements);
  if (!status)
    status = mesh_parts(a);
  if (!status)
    status = share_nodes(a);
  if (!status)
    status = put_together(a);
  if (!status)
    status = name_parts(a);
  if (!status)
    status = make_regions(a);
  return status ? status : tsi_hex_check_quality(a->context, a->hex);
}

tsolid_status tsolid_hex_assembly_create(tsolid_context *context, const tsolid_assembly *assembly,
                                         int n_parts, const tsolid_solid *const *solid,
                                         const tsolid_hex_part *part,
                                         const tsolid_hex_options *options, tsolid_hex **hex) {
  if (hex)
    *hex = NULL;
  if (!context || !hex)
    return TSOLID_ERROR_ARGUMENT;
  if (!assembly || !solid || n_parts != assembly->n_parts || !assembly->record)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, stage,
                    "A joined assembly and one solid per part of it are expected");
  tsolid_hex_options given = {0};
  if (options)
    given = *options;
  given.n_regions = 0;
  memset(given.divisions, 0, sizeof given.divisions);
  tsolid_hex_options checked = given;
  tsolid_status status = tsi_hex_check_options(context, &checked);
  if (status)
    return status;
  tsi_arena arena = tsi_arena_create(context);
  assembler a = {.context = context,
                 .arena = &arena,
                 .assembly = assembly,
                 .n_parts = n_parts,
                 .solid = solid,
                 .order = given.order == 2 ? 2 : 1};
  status = assemble(&a, part, &given);
  for (int k = 0; k < n_parts && a.part; k++)
    tsolid_hex_free(a.part[k].hex);
  tsi_arena_free(&arena);
  if (status)
    tsolid_hex_free(a.hex);
  else
    *hex = a.hex;
  return status;
}
