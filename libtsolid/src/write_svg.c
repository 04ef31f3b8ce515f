/* SPDX-License-Identifier: LGPL-2.1-or-later
 * A picture of the T-mesh in parametric space, as figures 2 and 3 of Zhang, Wang, Hughes (2012):
 *
 *   the core from outside, with T-junctions | the whole, an octant cut out | the section at half z
 *
 * The cross is laid into a cube as in transfinite.c: the core into a smaller cube inside, the arms
 * into the frusta around it. Then u = 1/2 is a plane, and with the octant above it cut out of the
 * cube no visible face hides another: nothing needs to be sorted. Boxes of the octree are filled by
 * level and drawn with thick lines; thin lines are what the closure and the bands added. */
#include "file_io.h"
#include "tmesh.h"

static const char stage[] = "write";

/* Lengths are in hundredths of a pixel: whole numbers. */
enum { WIDTH = 160000, SIZE = 23000, TOP = 7500, LEGEND = 58500 };

static const double SHARE = 0.2, MIDDLE = 0.5; /* of the cube, that an arm takes; the cut */

typedef struct picture {
  tsi_output out;
  const tsolid_boundary *boundary;
  const tsolid_tmesh *tmesh;
  int n_level[TSI_MAX_LEVELS], first_level, last_level;
  double origin[2], scale;
  int flat; /* the section: axes 0 and 1 as they are */
} picture;

/* ---- shapes
 * --------------------------------------------------------------------------------------------- */

static void put_text(picture *p, const char *text) {
  tsi_output_text(&p->out, text);
}

/* Axis 0 points to the left front, axis 1 to the right front, axis 2 up. */
static void put_point(picture *p, const double x[3]) {
  double right = p->flat ? x[0] : 0.8660254037844386 * (x[1] - x[0]);
  double down = p->flat ? 1.0 - x[1] : 0.5 * (x[0] + x[1]) - x[2];
  tsi_output_integer(&p->out, (long long)floor(p->origin[0] + p->scale * right + 0.5));
  put_text(p, " ");
  tsi_output_integer(&p->out, (long long)floor(p->origin[1] + p->scale * down + 0.5));
}

static void put_polygon(picture *p, int n, double (*corner)[3], const char *fill, int stroke) {
  put_text(p, "<path d=\"M");
  for (int i = 0; i < n; i++) {
    put_text(p, i ? "L" : "");
    put_point(p, corner[i]);
  }
  put_text(p, "Z\" fill=\"");
  put_text(p, fill);
  put_text(p, "\" stroke-width=\"");
  tsi_output_integer(&p->out, stroke);
  put_text(p, "\"/>\n");
}

static void put_dot(picture *p, const double x[3], int radius) {
  put_text(p, "<circle r=\"");
  tsi_output_integer(&p->out, radius);
  put_text(p, "\" transform=\"translate(");
  put_point(p, x);
  put_text(p, ")\"/>\n");
}

static void put_words(picture *p, int x, int y, int size, const char *text) {
  put_text(p, "<text x=\"");
  tsi_output_integer(&p->out, x);
  put_text(p, "\" y=\"");
  tsi_output_integer(&p->out, y);
  put_text(p, "\" font-size=\"");
  tsi_output_integer(&p->out, size);
  put_text(p, "\">");
  put_text(p, text);
  put_text(p, "</text>\n");
}

/* From sand over green to blue, darker on faces turned away from the light (light: 0 to 1). */
static void colour_of(const picture *p, int level, double light, char text[8]) {
  static const double anchor[3][3] = {{252, 240, 190}, {134, 204, 170}, {92, 140, 206}};
  static const char digit[] = "0123456789abcdef";
  int range = p->last_level - p->first_level;
  double f = range ? 2.0 * (level - p->first_level) / range : 0.0;
  int below = f < 1.0 ? 0 : 1;
  text[0] = '#';
  for (int c = 0; c < 3; c++) {
    double mixed = anchor[below][c] + (f - below) * (anchor[below + 1][c] - anchor[below][c]);
    int value = (int)(light * mixed);
    text[1 + 2 * c] = digit[value / 16];
    text[2 + 2 * c] = digit[value % 16];
  }
  text[7] = '\0';
}

static const double LIGHT[3] = {0.88, 0.78, 1.0};                        /* by normal */
static const char *const OUTSIDE[3] = {"#d9d9dd", "#c6c6cc", "#ececef"}; /* the input's faces */
static const char *const LAYER[2] = {"#f3e3e0", "#e8cbc6"};              /* inner, outer */

/* A rectangle normal to an axis, at `at`; lateral axes s < t. */
static void put_rectangle(picture *p, int axis, double at, const double box[4], const char *fill,
                          int stroke) {
  int s = tsi_side_s(2 * axis), t = tsi_side_t(2 * axis);
  double corner[4][3];
  for (int i = 0; i < 4; i++) {
    corner[i][axis] = at;
    corner[i][s] = box[i == 1 || i == 2];
    corner[i][t] = box[2 + (i > 1)];
  }
  put_polygon(p, 4, corner, fill, stroke);
}

static void begin_panel(picture *p, const char *title, int centre, int flat) {
  p->flat = flat;
  p->scale = flat ? 1.6 * SIZE : SIZE;
  p->origin[0] = flat ? centre - 0.5 * p->scale : centre;
  p->origin[1] = flat ? TOP + SIZE - 0.5 * p->scale : TOP + SIZE;
  put_text(p, "<g stroke=\"#222\" stroke-linejoin=\"round\">\n<g stroke=\"none\" fill=\"#222\" "
              "text-anchor=\"middle\">\n");
  put_words(p, centre, 4600, 2000, title);
  put_text(p, "</g>\n");
}

static void end_panel(picture *p) {
  put_text(p, "</g>\n");
}

/* ---- T-junctions
 * ----------------------------------------------------------------------------------------- */

static int dot_radius(const picture *p) {
  int most = 1;
  for (int side = 0; side < 6; side++)
    if (p->boundary->side[side].n_elements > most)
      most = p->boundary->side[side].n_elements;
  double radius = 0.2 * SIZE / sqrt((double)most);
  return (int)fmin(fmax(radius, 90.0), 420.0);
}

static int is_corner(double s, double t) {
  return (s == 0.0 || s == 1.0) && (t == 0.0 || t == 1.0);
}

/* The corners of the elements of a side; `cut`: not those of the quarter that is cut out. */
static void put_junctions(picture *p, int side, int cut) {
  const tsi_side *sd = &p->boundary->side[side];
  double x[3] = {1.0, 1.0, 1.0};
  put_text(p, "<g stroke=\"none\" fill=\"#c0201c\">\n");
  for (int k = 0; k < 4 * sd->n_elements; k++) {
    const double *box = sd->box + 4 * (size_t)(k / 4);
    double s = box[k & 1], t = box[2 + (k >> 1 & 1)];
    /* each place once: as a low corner, or on the high borders */
    if (((k & 1) && s < 1.0) || ((k >> 1 & 1) && t < 1.0) || is_corner(s, t) ||
        (cut && s > MIDDLE && t > MIDDLE))
      continue;
    x[tsi_side_s(side)] = s;
    x[tsi_side_t(side)] = t;
    put_dot(p, x, dot_radius(p));
  }
  put_text(p, "</g>\n");
}

/* ---- the core from outside
 * ------------------------------------------------------------------------------- */

static void put_core_face(picture *p, int axis) {
  const tsolid_tmesh *t = p->tmesh;
  int s = tsi_side_s(2 * axis), v = tsi_side_t(2 * axis), high = tsi_high_plane(t, axis);
  char fill[8];
  for (int b = 0; b < t->n_boxes; b++) {
    const int *i = t->box + 6 * (size_t)b;
    if (i[axis + 3] != t->n_lines[axis] - 1)
      continue;
    double box[4] = {t->line[s][i[s]], t->line[s][i[s + 3]], t->line[v][i[v]],
                     t->line[v][i[v + 3]]};
    colour_of(p, tsi_box_level(t, b), LIGHT[axis], fill);
    put_rectangle(p, axis, 1.0, box, fill, 150);
  }
  for (int c = 0; c < t->n_cells; c++) {
    const int *cell = t->cell + 6 * (size_t)c;
    const double *vs = t->plane_value[s], *vt = t->plane_value[v];
    double box[4] = {vs[cell[s]], vs[cell[s + 3]], vt[cell[v]], vt[cell[v + 3]]};
    if (t->cell_block[c] == 0 && cell[axis + 3] == high && box[0] < box[1] && box[2] < box[3])
      put_rectangle(p, axis, 1.0, box, "none", 50);
  }
}

static void put_core(picture *p) {
  begin_panel(p, "Core: cells by level, T-junctions", WIDTH / 6, 0);
  for (int axis = 0; axis < 3; axis++) {
    put_core_face(p, axis);
    put_junctions(p, 2 * axis + 1, 0);
  }
  end_panel(p);
}

/* ---- the section of core and layers
 * --------------------------------------------------------------------- */

/* Places in the cube of the point with lateral coordinates in the section normal to `axis`; side:
 * the arm, or -1 for the core, whose second lateral coordinate is no depth. */
static void place(int axis, int side, double along, double depth, double at, double x[3]) {
  int arm = side < 0 ? tsi_side_t(2 * axis) : tsi_side_axis(side);
  int other = 3 - axis - arm;
  double inside = SHARE + along * (1.0 - 2.0 * SHARE);
  x[axis] = at;
  if (side < 0) {
    x[other] = inside;
    x[arm] = SHARE + depth * (1.0 - 2.0 * SHARE);
    return;
  }
  x[other] = (1.0 - depth) * inside + depth * along;
  x[arm] = side & 1 ? 1.0 - SHARE * (1.0 - depth) : SHARE * (1.0 - depth);
}

/* One cell's section: [a0, a1] along, [b0, b1] across (depth / R in arms). */
static void put_section(picture *p, int axis, int side, const double box[4], const char *fill,
                        int stroke) {
  double corner[4][3];
  for (int i = 0; i < 4; i++)
    place(axis, side, box[i == 1 || i == 2], box[2 + (i > 1)], MIDDLE, corner[i]);
  put_polygon(p, 4, corner, fill, stroke);
}

/* Keeps what lies above the cut; 0: nothing. */
static int above_cut(double range[2]) {
  range[0] = fmax(range[0], MIDDLE);
  return range[0] < range[1];
}

static void put_arm_cell(picture *p, int axis, const int *cell, int side, int quarter) {
  const tsolid_tmesh *t = p->tmesh;
  int arm = tsi_side_axis(side), other = 3 - axis - arm;
  const double *va = t->plane_value[arm], *vo = t->plane_value[other];
  double height = t->arm_height[side], edge = side & 1 ? 1.0 : 0.0;
  double near = fabs(va[cell[side & 1 ? arm : arm + 3]] - edge) / height;
  double far = fabs(va[cell[side & 1 ? arm + 3 : arm]] - edge) / height;
  double box[4] = {vo[cell[other]], vo[cell[other + 3]], near, far};
  if (box[0] < box[1] && near < far && (!quarter || above_cut(box)))
    put_section(p, axis, side, box, LAYER[near > 0.25], 50);
}

/* Cells of the core and the four arms that the plane at half of `axis` meets; `quarter`: only above
 * the cut on both other axes. */
static void put_cells(picture *p, int axis, int quarter) {
  const tsolid_tmesh *t = p->tmesh;
  const double *v = t->plane_value[axis];
  int s = tsi_side_s(2 * axis), w = tsi_side_t(2 * axis);
  for (int c = 0; c < t->n_cells; c++) {
    const int *cell = t->cell + 6 * (size_t)c;
    int side = t->cell_block[c] - 1;
    if (!(v[cell[axis]] < MIDDLE && MIDDLE <= v[cell[axis + 3]]) ||
        (side >= 0 && (tsi_side_axis(side) == axis || (quarter && !(side & 1)))))
      continue;
    if (side >= 0) {
      put_arm_cell(p, axis, cell, side, quarter);
      continue;
    }
    double box[4] = {t->plane_value[s][cell[s]], t->plane_value[s][cell[s + 3]],
                     t->plane_value[w][cell[w]], t->plane_value[w][cell[w + 3]]};
    if (box[0] < box[1] && box[2] < box[3] && (!quarter || (above_cut(box) && above_cut(box + 2))))
      put_section(p, axis, -1, box, "none", 50);
  }
}

static void put_boxes(picture *p, int axis, int quarter) {
  const tsolid_tmesh *t = p->tmesh;
  int s = tsi_side_s(2 * axis), w = tsi_side_t(2 * axis);
  char fill[8];
  for (int b = 0; b < t->n_boxes; b++) {
    const int *i = t->box + 6 * (size_t)b;
    double box[4] = {t->line[s][i[s]], t->line[s][i[s + 3]], t->line[w][i[w]],
                     t->line[w][i[w + 3]]};
    if (!(t->line[axis][i[axis]] < MIDDLE && MIDDLE <= t->line[axis][i[axis + 3]]) ||
        (quarter && !(above_cut(box) && above_cut(box + 2))))
      continue;
    colour_of(p, tsi_box_level(t, b), p->flat ? 1.0 : LIGHT[axis], fill);
    put_section(p, axis, -1, box, fill, 150);
  }
}

/* ---- the whole, an octant cut out
 * ------------------------------------------------------------------------- */

/* A side's element without the quarter above the cut. */
static void put_side_element(picture *p, int axis, const double *e) {
  int s = tsi_side_s(2 * axis), t = tsi_side_t(2 * axis);
  double box[4] = {e[0], e[1], e[2], e[3]};
  if (e[0] >= MIDDLE && e[2] >= MIDDLE)
    return;
  if (e[0] < MIDDLE && e[2] < MIDDLE && e[1] > MIDDLE && e[3] > MIDDLE) {
    const double at[6][2] = {{e[0], e[2]},     {e[1], e[2]},   {e[1], MIDDLE},
                             {MIDDLE, MIDDLE}, {MIDDLE, e[3]}, {e[0], e[3]}};
    double corner[6][3];
    for (int i = 0; i < 6; i++) {
      corner[i][axis] = 1.0;
      corner[i][s] = at[i][0];
      corner[i][t] = at[i][1];
    }
    put_polygon(p, 6, corner, OUTSIDE[axis], 90);
    return;
  }
  if (e[2] >= MIDDLE)
    box[1] = fmin(e[1], MIDDLE);
  if (e[0] >= MIDDLE)
    box[3] = fmin(e[3], MIDDLE);
  put_rectangle(p, axis, 1.0, box, OUTSIDE[axis], 90);
}

static void put_cut(picture *p) {
  begin_panel(p, "An octant cut out: input, two layers, core", WIDTH / 2, 0);
  for (int axis = 0; axis < 3; axis++) {
    const tsi_side *side = &p->boundary->side[2 * axis + 1];
    for (int e = 0; e < side->n_elements; e++)
      put_side_element(p, axis, side->box + 4 * (size_t)e);
    put_junctions(p, 2 * axis + 1, 1);
    put_boxes(p, axis, 1);
    put_cells(p, axis, 1);
  }
  end_panel(p);
}

/* T-junctions where the section meets lines of the four sides. */
static void put_section_junctions(picture *p) {
  put_text(p, "<g stroke=\"none\" fill=\"#c0201c\">\n");
  for (int side = 0; side < 4; side++) {
    const tsi_side *sd = &p->boundary->side[side];
    for (int e = 0; e < sd->n_elements; e++) {
      const double *box = sd->box + 4 * (size_t)e;
      double x[3];
      if (!(box[2] < MIDDLE && MIDDLE <= box[3]) || box[0] == 0.0)
        continue;
      place(2, side, box[0], 1.0, MIDDLE, x);
      put_dot(p, x, dot_radius(p));
    }
  }
  put_text(p, "</g>\n");
}

static void put_flat(picture *p) {
  begin_panel(p, "Section at half height", 5 * (WIDTH / 6), 1);
  put_boxes(p, 2, 0);
  put_cells(p, 2, 0);
  put_section_junctions(p);
  end_panel(p);
}

/* ---- document
 * --------------------------------------------------------------------------------------------- */

static void put_key(picture *p, int x, const char *fill) {
  put_text(p, "<rect stroke=\"#222\" stroke-width=\"90\" width=\"2000\" height=\"2000\" x=\"");
  tsi_output_integer(&p->out, x);
  put_text(p, "\" y=\"");
  tsi_output_integer(&p->out, LEGEND - 1700);
  put_text(p, "\" fill=\"");
  put_text(p, fill);
  put_text(p, "\"/>\n");
}

static void put_legend(picture *p) {
  int x = 3000;
  char fill[8];
  put_text(p, "<g fill=\"#222\">\n");
  for (int level = p->first_level; level <= p->last_level; level++, x += 16000) {
    colour_of(p, level, 1.0, fill);
    put_key(p, x, fill);
    put_text(p, "<text font-size=\"1900\" x=\"");
    tsi_output_integer(&p->out, x + 2700);
    put_text(p, "\" y=\"");
    tsi_output_integer(&p->out, LEGEND);
    put_text(p, "\">level ");
    tsi_output_integer(&p->out, level);
    put_text(p, ": ");
    tsi_output_integer(&p->out, p->n_level[level]);
    put_text(p, "</text>\n");
  }
  for (int k = 0; k < 2; k++, x += 14500) {
    put_key(p, x, LAYER[k]);
    put_words(p, x + 2700, LEGEND, 1900, k ? "outer layer" : "inner layer");
  }
  put_text(p, "<circle fill=\"#c0201c\" r=\"500\" cx=\"");
  tsi_output_integer(&p->out, x + 1000);
  put_text(p, "\" cy=\"");
  tsi_output_integer(&p->out, LEGEND - 700);
  put_text(p, "\"/>\n");
  put_words(p, x + 2700, LEGEND, 1900, "T-junction");
  put_words(p, 3000, LEGEND + 3800, 1900,
            "Thick lines: cells of the octree. Thin lines: cells of the layers, and cuts by the "
            "closure that makes the functions sum to one.");
  put_text(p, "</g>\n");
}

static void put_document(picture *p) {
  put_text(p, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1600\" height=\"650\" viewBox=\"0 "
              "0 160000 65000\" font-family=\"sans-serif\">\n"
              "<rect width=\"160000\" height=\"65000\" fill=\"#fff\"/>\n");
  put_core(p);
  put_cut(p);
  put_flat(p);
  put_legend(p);
  put_text(p, "</svg>\n");
}

tsolid_status tsolid_write_svg(tsolid_context *context, const tsolid_space *space,
                               const char *path) {
  if (!context || !space || !path)
    return TSOLID_ERROR_ARGUMENT;
  picture p = {.boundary = space->boundary, .tmesh = space->tmesh};
  tsi_box_levels(p.tmesh, p.n_level);
  while (p.first_level + 1 < TSI_MAX_LEVELS && p.n_level[p.first_level] == 0)
    p.first_level++;
  for (int level = p.first_level; level < TSI_MAX_LEVELS; level++)
    if (p.n_level[level])
      p.last_level = level;
  tsolid_status status = TSOLID_OK;
  if (tsi_output_open(&p.out, context, stage, path) == TSOLID_OK) {
    put_document(&p);
    status = tsi_progress(context, stage, 1.0);
  }
  return tsi_output_close(&p.out, status);
}
