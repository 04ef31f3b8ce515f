/* SPDX-License-Identifier: LGPL-2.1-or-later
 * The core: a strongly balanced octree with the T-junction rule.
 *
 * Source: Zhang, Wang, Hughes (2012), section 3. Starting from the core as one cell, a cell is
 * split while a boundary face of it holds more than one face T-junction, or an edge more than one
 * edge T-junction; T-junctions of equal position count once. Here a cell is a triple of intervals
 * of the axis trees; a split halves those axes that break a rule (the anisotropic octree: levels
 * and balance are per axis). Strong balance: cells that touch, be it at a corner, differ by at most
 * one level per axis. And at least `min_cells` cells stand along every axis.
 *
 * The paper's own octree splits all axes together; there, an axis with no T-junction left in the
 * interval is split in the middle. Its tree then gets a new value, and all cells are painted anew.
 *
 * Cells are painted on the grid of all values, so that neighbours are found by looking. */
#include "octree.h"
#include "axis_tree.h"
#include "tmesh.h"

static const char *const STAGE = "tmesh";

enum { DEFAULT_MIN_CELLS = 3, MAX_MIN_CELLS = 256, MAX_GRID = 1 << 27 };

typedef struct leaf {
  int node[3]; /* intervals of the axis trees */
  int split;   /* no leaf any more */
} leaf;

/* T-junctions of one side, on the grid of its two axes' values. */
typedef struct junctions {
  int n[2];
  int *below; /* (n[0] + 1) x (n[1] + 1): number of T-junctions with smaller indices */
} junctions;

typedef struct octree {
  tsolid_context *context;
  tsi_arena *arena;
  const tsi_octree_input *input;
  tsi_axis_tree axis[3];
  unsigned char *wanted[3]; /* per node of the trees: to be split in the middle */
  int n_wanted;
  junctions side[6];
  int n_leaves, capacity;
  leaf *leaf; /* our own growing array */
  int *grid;  /* leaf of every elementary cell; axis 0 fastest */
} octree;

static const tsi_interval *interval_of(const octree *o, const leaf *l, int axis) {
  return &o->axis[axis].node[l->node[axis]];
}

static int can_split(const octree *o, const leaf *l, int axis) {
  return interval_of(o, l, axis)->child[0] >= 0 ||
         (o->input->together >> axis & 1 && tsi_interval_has_middle(&o->axis[axis], l->node[axis]));
}

/* ---- T-junctions
 * ------------------------------------------------------------------------------------------ */

/* Marks the side's T-junctions and sums them up from the low corner. */
static int count_junctions(octree *o, int side) {
  const tsi_junctions *list = &o->input->side[side];
  const tsi_axis_tree *axis[2] = {&o->axis[tsi_side_s(side)], &o->axis[tsi_side_t(side)]};
  junctions *j = &o->side[side];
  for (int i = 0; i < 2; i++)
    j->n[i] = axis[i]->n_values;
  int stride = j->n[0] + 1;
  j->below = tsi_arena_new(o->arena, (size_t)stride * (size_t)(j->n[1] + 1), sizeof *j->below);
  if (!j->below)
    return 0;
  for (int i = 0; i < list->n; i++) {
    int a = tsi_axis_tree_nearest(axis[0], list->at[2 * (size_t)i]);
    int b = tsi_axis_tree_nearest(axis[1], list->at[2 * (size_t)i + 1]);
    int is_corner = (a == 0 || a == j->n[0] - 1) && (b == 0 || b == j->n[1] - 1);
    if (!is_corner) /* the cube's corners are no T-junctions */
      j->below[a + 1 + (b + 1) * stride] = 1;
  }
  for (int b = 1; b <= j->n[1]; b++)
    for (int a = 1; a <= j->n[0]; a++)
      j->below[a + b * stride] += j->below[a - 1 + b * stride] + j->below[a + (b - 1) * stride] -
                                  j->below[a - 1 + (b - 1) * stride];
  return 1;
}

/* T-junctions with indices a0 <= a <= a1, b0 <= b <= b1. */
static int junctions_in(const junctions *j, int a0, int a1, int b0, int b1) {
  int stride = j->n[0] + 1;
  if (a1 < a0 || b1 < b0)
    return 0;
  return j->below[(a1 + 1) + (b1 + 1) * stride] - j->below[a0 + (b1 + 1) * stride] -
         j->below[(a1 + 1) + b0 * stride] + j->below[a0 + b0 * stride];
}

/* Axes with more than one value left inside: what can break the T-junction rule (bits). */
static int crowded_axes(const octree *o, const leaf *l) {
  int axes = 0;
  for (int a = 0; a < 3; a++)
    axes |= (interval_of(o, l, a)->last - interval_of(o, l, a)->first > 2) << a;
  return axes;
}

/* The T-junction rule: more than one inside a boundary face, or inside one of its edges. */
static int breaks_rule(const octree *o, const leaf *l) {
  for (int side = 0; side < 6; side++) {
    int axis = tsi_side_axis(side);
    const tsi_interval *across = interval_of(o, l, axis);
    if (side & 1 ? across->last != o->axis[axis].n_values - 1 : across->first != 0)
      continue;
    const tsi_interval *s = interval_of(o, l, tsi_side_s(side));
    const tsi_interval *t = interval_of(o, l, tsi_side_t(side));
    const junctions *j = &o->side[side];
    if (junctions_in(j, s->first + 1, s->last - 1, t->first + 1, t->last - 1) > 1 ||
        junctions_in(j, s->first, s->first, t->first + 1, t->last - 1) > 1 ||
        junctions_in(j, s->last, s->last, t->first + 1, t->last - 1) > 1 ||
        junctions_in(j, s->first + 1, s->last - 1, t->first, t->first) > 1 ||
        junctions_in(j, s->first + 1, s->last - 1, t->last, t->last) > 1)
      return 1;
  }
  return 0;
}

/* Axes along which fewer than min_cells cells fit at this leaf's level (bits). */
static int coarse_axes(const octree *o, const leaf *l) {
  int axes = 0;
  for (int a = 0; a < 3; a++) {
    const tsi_interval *i = interval_of(o, l, a);
    double width = o->axis[a].value[i->last] - o->axis[a].value[i->first];
    axes |= (can_split(o, l, a) && width * o->input->min_cells > 1.01) << a;
  }
  return axes;
}

/* ---- leaves
 * --------------------------------------------------------------------------------------------------
 */

static void paint(octree *o, int index) {
  const leaf *l = &o->leaf[index];
  const tsi_interval *i[3] = {interval_of(o, l, 0), interval_of(o, l, 1), interval_of(o, l, 2)};
  size_t n0 = (size_t)o->axis[0].n_values - 1, n1 = (size_t)o->axis[1].n_values - 1;
  for (int z = i[2]->first; z < i[2]->last; z++)
    for (int y = i[1]->first; y < i[1]->last; y++)
      for (int x = i[0]->first; x < i[0]->last; x++)
        o->grid[((size_t)z * n1 + (size_t)y) * n0 + (size_t)x] = index;
}

static int add_leaf(octree *o, const int node[3]) {
  if (o->n_leaves == o->capacity) {
    int more = o->capacity ? 2 * o->capacity : 256;
    leaf *grown =
        more > TSI_MAX_COUNT ? NULL : tsi_new(&o->context->allocator, (size_t)more, sizeof *grown);
    if (!grown)
      return 0;
    if (o->n_leaves)
      memcpy(grown, o->leaf, (size_t)o->n_leaves * sizeof *grown);
    tsi_delete(&o->context->allocator, o->leaf);
    o->leaf = grown;
    o->capacity = more;
  }
  o->leaf[o->n_leaves] = (leaf){{node[0], node[1], node[2]}, 0};
  paint(o, o->n_leaves++);
  return 1;
}

static int split_leaf(octree *o, int index, int axes) {
  int n[3], node[3];
  for (int a = 0; a < 3; a++)
    n[a] = axes >> a & 1 ? 2 : 1;
  o->leaf[index].split = 1;
  for (int k = 0; k < n[0] * n[1] * n[2]; k++) {
    int part[3] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};
    for (int a = 0; a < 3; a++)
      node[a] =
          n[a] == 2 ? interval_of(o, &o->leaf[index], a)->child[part[a]] : o->leaf[index].node[a];
    if (!add_leaf(o, node))
      return 0;
  }
  return 1;
}

/* Axes in which a cell that touches this one is finer by more than a level (bits). */
static int unbalanced_axes(const octree *o, const leaf *l) {
  int lo[3], hi[3], axes = 0;
  size_t n[3];
  for (int a = 0; a < 3; a++) {
    const tsi_interval *i = interval_of(o, l, a);
    n[a] = (size_t)o->axis[a].n_values - 1;
    lo[a] = i->first > 0 ? i->first - 1 : 0;
    hi[a] = i->last < (int)n[a] ? i->last : (int)n[a] - 1; /* last elementary cell looked at */
  }
  for (int z = lo[2]; z <= hi[2]; z++)
    for (int y = lo[1]; y <= hi[1]; y++)
      for (int x = lo[0]; x <= hi[0]; x++) {
        const leaf *other = &o->leaf[o->grid[((size_t)z * n[1] + (size_t)y) * n[0] + (size_t)x]];
        if (other == l) { /* skip to the far end of ourselves */
          x = interval_of(o, l, 0)->last - 1;
          continue;
        }
        for (int a = 0; a < 3; a++)
          axes |= (can_split(o, l, a) &&
                   interval_of(o, other, a)->level - interval_of(o, l, a)->level > 1)
                  << a;
      }
  return axes;
}

/* The axes to split of a leaf that breaks a rule, and those that are split together with them. */
static int axes_to_split(const octree *o, const leaf *l) {
  int axes = coarse_axes(o, l) | unbalanced_axes(o, l), together = o->input->together;
  if (breaks_rule(o, l))
    axes |= crowded_axes(o, l);
  for (int a = 0; a < 3 && axes & together; a++)
    axes |= together & (can_split(o, l, a) << a);
  return axes;
}

/* Notes intervals that have no T-junction left to be split at; 0: there are none. */
static int want_middles(octree *o, const leaf *l, int axes) {
  int n = 0;
  for (int a = 0; a < 3; a++)
    if (axes >> a & 1 && interval_of(o, l, a)->child[0] < 0) {
      o->wanted[a][l->node[a]] = 1;
      n++;
    }
  o->n_wanted += n;
  return n;
}

/* The grid of all values, with the leaves painted on it, and the T-junctions on it. */
static tsolid_status make_grid(octree *o) {
  double cells = 1.0;
  for (int a = 0; a < 3; a++)
    cells *= o->axis[a].n_values - 1;
  if (cells > MAX_GRID)
    return tsi_fail(o->context, TSOLID_ERROR_REFUSED, STAGE,
                    "The sides' knots make a grid of %.0f cells, more than the %d that are taken; "
                    "give sides with fewer knots",
                    cells, MAX_GRID);
  tsi_delete(&o->context->allocator, o->grid);
  o->grid = tsi_new(&o->context->allocator, (size_t)cells, sizeof *o->grid);
  if (!o->grid)
    return tsi_no_memory(o->context, STAGE);
  for (int i = 0; i < o->n_leaves; i++)
    if (!o->leaf[i].split)
      paint(o, i);
  for (int a = 0; a < 3; a++) {
    o->wanted[a] = tsi_arena_new(o->arena, (size_t)o->axis[a].n_nodes, 1);
    if (!o->wanted[a])
      return tsi_no_memory(o->context, STAGE);
  }
  o->n_wanted = 0;
  for (int side = 0; side < 6; side++)
    if (!count_junctions(o, side))
      return tsi_no_memory(o->context, STAGE);
  return TSOLID_OK;
}

static tsolid_status add_middles(octree *o) {
  for (int a = 0; a < 3; a++)
    if (!tsi_axis_tree_halve(&o->axis[a], o->wanted[a], o->arena))
      return tsi_no_memory(o->context, STAGE);
  return make_grid(o);
}

/* Splits until every leaf keeps the rule and the balance. */
static tsolid_status subdivide(octree *o) {
  int root[3] = {0, 0, 0};
  if (!add_leaf(o, root))
    return tsi_no_memory(o->context, STAGE);
  for (int changed = 1; changed;) {
    changed = 0;
    for (int i = 0; i < o->n_leaves; i++) {
      const leaf *l = &o->leaf[i];
      if (l->split)
        continue;
      int axes = axes_to_split(o, l);
      if (axes == 0 || want_middles(o, l, axes))
        continue;
      if (!split_leaf(o, i, axes))
        return tsi_no_memory(o->context, STAGE);
      changed = 1;
    }
    changed |= o->n_wanted > 0;
    tsolid_status status = o->n_wanted ? add_middles(o) : TSOLID_OK;
    if (status == TSOLID_OK)
      status = tsi_progress(o->context, STAGE, 0.2);
    if (status != TSOLID_OK)
      return status;
  }
  return TSOLID_OK;
}

/* ---- result
 * ---------------------------------------------------------------------------------------------------
 */

/* Keeps the values that are corners of leaves, as lines; line_of: for every value its line. */
static int choose_lines(const octree *o, tsi_octree *tree, int *line_of[3]) {
  for (int a = 0; a < 3; a++) {
    int n = o->axis[a].n_values, n_lines = 0;
    tree->line[a] = tsi_arena_new(o->arena, (size_t)n, sizeof(double));
    line_of[a] = tsi_arena_new(o->arena, (size_t)n, sizeof(int));
    if (!tree->line[a] || !line_of[a])
      return 0;
    for (int i = 0; i < o->n_leaves; i++)
      if (!o->leaf[i].split) {
        line_of[a][interval_of(o, &o->leaf[i], a)->first] = 1;
        line_of[a][interval_of(o, &o->leaf[i], a)->last] = 1;
      }
    for (int i = 0; i < n; i++)
      if (line_of[a][i]) {
        tree->line[a][n_lines] = o->axis[a].value[i];
        line_of[a][i] = n_lines++;
      }
    tree->n_lines[a] = n_lines;
  }
  return 1;
}

/* R of each arm: twice the mean width of the core cells next to it. */
static void choose_arm_heights(const octree *o, double height[6]) {
  for (int side = 0; side < 6; side++) {
    int axis = tsi_side_axis(side), s = tsi_side_s(side), t = tsi_side_t(side);
    height[side] = 0.0;
    for (int i = 0; i < o->n_leaves; i++) {
      const leaf *l = &o->leaf[i];
      double width[3];
      for (int a = 0; a < 3; a++)
        width[a] = o->axis[a].value[interval_of(o, l, a)->last] -
                   o->axis[a].value[interval_of(o, l, a)->first];
      if (!l->split && (side & 1 ? interval_of(o, l, axis)->last == o->axis[axis].n_values - 1
                                 : interval_of(o, l, axis)->first == 0))
        height[side] += 2.0 * width[axis] * width[s] * width[t];
    }
  }
}

static int make_boxes(const octree *o, int *const line_of[3], tsi_octree *tree) {
  tree->box = tsi_arena_new(o->arena, (size_t)o->n_leaves, 6 * sizeof *tree->box);
  tree->level = tsi_arena_new(o->arena, (size_t)o->n_leaves, sizeof *tree->level);
  if (!tree->box || !tree->level)
    return 0;
  for (int i = 0; i < o->n_leaves; i++) {
    if (o->leaf[i].split)
      continue;
    int *row = tree->box + 6 * (size_t)tree->n_boxes, *level = &tree->level[tree->n_boxes++];
    for (int a = 0; a < 3; a++) {
      int own = interval_of(o, &o->leaf[i], a)->level;
      *level = own > *level ? own : *level;
      row[a] = line_of[a][interval_of(o, &o->leaf[i], a)->first];
      row[a + 3] = line_of[a][interval_of(o, &o->leaf[i], a)->last];
    }
  }
  return 1;
}

/* One tree per axis, from the T-junctions of the four sides that carry it. */
static tsolid_status plant(octree *o) {
  for (int a = 0; a < 3; a++) {
    size_t room = 0, n = 0;
    for (int side = 0; side < 6; side++)
      room += (size_t)o->input->side[side].n;
    double *value = tsi_arena_new(o->arena, room, sizeof *value);
    for (int side = 0; side < 6 && value; side++)
      for (int i = 0; i < o->input->side[side].n && tsi_side_axis(side) != a; i++)
        value[n++] = o->input->side[side].at[2 * (size_t)i + (tsi_side_s(side) == a ? 0 : 1)];
    int least = o->input->together >> a & 1 ? 1 : o->input->min_cells; /* else by middles */
    if (!value || !tsi_axis_tree_from_values((int)n, value, least, o->arena, &o->axis[a]))
      return tsi_no_memory(o->context, STAGE);
  }
  return make_grid(o);
}

tsolid_status tsi_octree_create(tsolid_context *context, const tsi_octree_input *input,
                                tsi_arena *arena, tsi_octree *tree) {
  octree o = {.context = context, .arena = arena, .input = input};
  int *line_of[3];
  *tree = (tsi_octree){.n_boxes = 0};
  tsolid_status status = plant(&o);
  if (status == TSOLID_OK)
    status = subdivide(&o);
  if (status == TSOLID_OK && !(choose_lines(&o, tree, line_of) && make_boxes(&o, line_of, tree)))
    status = tsi_no_memory(context, STAGE);
  if (status == TSOLID_OK)
    choose_arm_heights(&o, tree->arm_height);
  tsi_delete(&context->allocator, o.leaf);
  tsi_delete(&context->allocator, o.grid);
  return status;
}

/* ---- from a boundary
 * ------------------------------------------------------------------------------------------ */

/* The corners of the side's Bezier elements. */
static int collect_corners(const tsi_side *side, tsi_arena *arena, tsi_junctions *list) {
  double *at = tsi_arena_new(arena, 8 * (size_t)side->n_elements, sizeof *at);
  if (!at)
    return 0;
  for (size_t k = 0; k < 4 * (size_t)side->n_elements; k++) {
    const double *box = side->box + 4 * (k / 4);
    at[2 * k] = box[k & 1];
    at[2 * k + 1] = box[2 + (k >> 1 & 1)];
  }
  *list = (tsi_junctions){4 * side->n_elements, at};
  return 1;
}

static tsolid_status build(tsolid_context *context, const tsolid_boundary *boundary,
                           const tsolid_tmesh_options *options, tsolid_tmesh **tmesh) {
  tsi_arena arena = tsi_arena_create(context);
  tsi_octree_input input = {.min_cells =
                                options->min_cells ? options->min_cells : DEFAULT_MIN_CELLS,
                            .together = options->isotropic ? 7 : 0};
  int flags = (options->analysis_suitable_off ? TSI_TMESH_CLOSURE_OFF : 0) |
              (options->sharp_core ? TSI_TMESH_SHARP_CORE : 0);
  tsi_octree tree;
  tsolid_status status = TSOLID_OK;
  for (int side = 0; side < 6 && status == TSOLID_OK; side++)
    if (!collect_corners(&boundary->side[side], &arena, &input.side[side]))
      status = tsi_no_memory(context, STAGE);
  if (status == TSOLID_OK)
    status = tsi_octree_create(context, &input, &arena, &tree);
  if (status == TSOLID_OK)
    status = tsi_tmesh_from_boxes(context, tree.n_lines, (const double *const *)tree.line,
                                  tree.n_boxes, tree.box, tree.arm_height, flags, tmesh);
  if (status == TSOLID_OK)
    status = tsi_tmesh_set_levels(context, *tmesh, tree.level);
  if (status != TSOLID_OK) {
    tsolid_tmesh_free(*tmesh);
    *tmesh = NULL;
  }
  tsi_arena_free(&arena);
  return status;
}

tsolid_status tsolid_tmesh_create(tsolid_context *context, const tsolid_boundary *boundary,
                                  const tsolid_tmesh_options *options, tsolid_tmesh **tmesh) {
  static const tsolid_tmesh_options defaults = {0};
  if (!context || !boundary || !tmesh)
    return TSOLID_ERROR_ARGUMENT;
  *tmesh = NULL;
  if (!options)
    options = &defaults;
  if (options->min_cells < 0 || options->min_cells > MAX_MIN_CELLS)
    return tsi_fail(context, TSOLID_ERROR_ARGUMENT, STAGE,
                    "The least number of core cells per axis must be 1 to %d, not %d",
                    MAX_MIN_CELLS, options->min_cells);
  return build(context, boundary, options, tmesh);
}
