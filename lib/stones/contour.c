/* The sub-pixel contour: each crack between two pixels of different colours is a gate, from one pixel's centre to the
 * other's; through the gates go the lines that fit as many of them as there are around each place. */
#include "stones/contour.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

/* A gate: the middle of a crack of the drawing, px from the origin; or where the drawing's greys say the edge is. */
typedef struct gate {
    double x, y;
    int upright;  /* the crack is */
    double crack; /* where that lies, across it */
    double give;  /* how far a line may miss the place, of the way from centre to centre */
} gate;

#define SMOOTH_GIVE 0.3

enum { REACH = PV_CONTOUR_REACH };

typedef struct sketch {
    pave_context *context;
    const pv_net *net;
    const pv_tess_place *place;
    int32_t x, y;       /* the origin, px: near what is drawn, so that it is drawn alike wherever it lies */
    int32_t left, top;  /* of the raster from there, in its own pixels */
    pv_outline *out;
    gate *gates; /* of the chain under way, and REACH before and after it */
    int32_t room, before, count, total;
    double slide;
    int32_t *xy;
    int32_t path_room;
} sketch;

static int32_t colour_at(const pv_net *net, int32_t x, int32_t y)
{
    const pv_pieces *p = net->pieces;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return -1;
    return p->colour[p->face[(int64_t)y * p->width + x]];
}

static void colours_ahead(const pv_net *net, int32_t x, int32_t y, int32_t way, int32_t *left, int32_t *right)
{
    int32_t lx = x - (way == 2 || way == 4), ly = y - (way == 0 || way == 2);
    int32_t rx = x - (way == 4 || way == 6), ry = y - (way == 2 || way == 4);
    *left = colour_at(net, lx, ly);
    *right = colour_at(net, rx, ry);
}

static int32_t floor_by(int32_t a, int32_t b)
{
    return a / b - (a % b < 0);
}

/* All that is drawn next is counted from the px that holds a junction. */
static void set_origin(sketch *s, int32_t j)
{
    const pv_tess_place *p = s->place;
    s->x = floor_by(p->x + s->net->x[j], p->scale);
    s->y = floor_by(p->y + s->net->y[j], p->scale);
    s->left = p->x - s->x * p->scale;
    s->top = p->y - s->y * p->scale;
}

/* The drawing's crack that a crack from (x, y) is part of. */
static gate gate_of(const sketch *s, int32_t x, int32_t y, int32_t way)
{
    int32_t scale = s->place->scale;
    int upright = way == 2 || way == 6;
    x = x - (way == 4) + s->left;
    y = y - (way == 2) + s->top;
    double half = 0.5;
    return upright ? (gate){ (double)x / scale, floor_by(y, scale) + half, 1, (double)x / scale, 1 }
                   : (gate){ floor_by(x, scale) + half, (double)y / scale, 0, (double)y / scale, 1 };
}

/* Moves a gate to where the edge of a smooth drawing is. */
static void find_edge(const sketch *s, gate *g)
{
    const pave_image *drawing = s->place->drawing;
    double way, *across = g->upright ? &g->x : &g->y;
    if (!drawing || floor(g->crack) < g->crack ||
        !pv_isoline(drawing, s->x + (int32_t)floor(g->x), s->y + (int32_t)floor(g->y), g->upright, &way))
        return;
    *across += way;
    g->give = SMOOTH_GIVE;
}

static int same_gate(const gate *a, const gate *b)
{
    return a->upright == b->upright && a->crack == b->crack && (a->upright ? a->y == b->y : a->x == b->x);
}

/* The next gates along a contour between two colours, from a lattice point on; it ends where a third colour comes. */
static int32_t follow(const sketch *s, int32_t x, int32_t y, int32_t way, int32_t most, gate *out)
{
    int32_t left, right, count = 0;
    colours_ahead(s->net, x, y, way, &left, &right);
    int32_t a = left, b = right;
    for (int32_t step = 0; step < 4 * most * s->place->scale; step++) {
        gate g = gate_of(s, x, y, way);
        if (!count || !same_gate(&g, &out[count - 1])) {
            if (count == most)
                return count;
            out[count] = g;
            find_edge(s, &out[count++]);
        }
        x += (way == 0) - (way == 4);
        y += (way == 6) - (way == 2);
        colours_ahead(s->net, x, y, way, &left, &right);
        if (left == a && right == a)
            way = (way + 6) & 7;
        else if (left == b && right == b)
            way = (way + 2) & 7;
        else if (left != a || right != b)
            return count;
    }
    return count;
}

typedef struct line {
    double x, y, dx, dy; /* a point, and a direction of length 1 */
} line;

/* Through the middle of gates from..to-1, the way from their first half to the other. */
static int fit(const gate *g, int32_t count, line *out)
{
    int32_t half = count / 2;
    double x = 0, y = 0, dx = 0, dy = 0;
    for (int32_t i = 0; i < count; i++) {
        x += g[i].x;
        y += g[i].y;
        int32_t side = (i >= count - half) - (i < half);
        dx += side * g[i].x;
        dy += side * g[i].y;
    }
    double length = sqrt(dx * dx + dy * dy);
    if (!(length > 0))
        return 0;
    *out = (line){ x / count, y / count, dx / length, dy / length };
    return 1;
}

static double offset(const line *l, double x, double y)
{
    return l->dx * (y - l->y) - l->dy * (x - l->x);
}

/* How far a line misses a gate's ends, px along the gate; negative if it goes through. */
static double miss(const line *l, const gate *g, double half)
{
    double along = fabs(g->upright ? l->dy : l->dx);
    return fabs(offset(l, g->x, g->y)) - half * g->give * along;
}

static int goes_through(const line *l, const gate *g, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        if (miss(l, &g[i], 0.49) > 0)
            return 0;
    return 1;
}

/* The line for gate `at` among `count`: of all that are centred there, one that passes somewhat fewer gates than the
 * longest, for that one cuts bends short. `between`: centred before gate `at` instead. */
static int line_at(const gate *g, int32_t count, int32_t at, int between, line *out)
{
    int32_t most = 0, good[REACH + 1], goods = 0;
    for (int32_t k = 1; k <= REACH && k <= most + 3; k++) {
        int32_t from = at - k, to = at + k + !between;
        line l;
        if (from < 0 || to > count)
            break;
        if (fit(g + from, to - from, &l) && goes_through(&l, g + from, to - from))
            good[goods++] = most = k;
    }
    if (!goods)
        return 0;
    int32_t want = most == REACH ? REACH : (most * 2 + 2) / 3, k = good[0];
    for (int32_t i = 0; i < goods; i++)
        if (good[i] <= want)
            k = good[i];
    return fit(g + at - k, 2 * k + !between, out);
}

/* The longest line through gates that begin at `at` and go on by `step`; returns how many it goes through. */
static int32_t line_from(const gate *g, int32_t count, int32_t at, int32_t step, line *out)
{
    gate some[REACH];
    int32_t most = 0;
    for (int32_t k = 0; k < REACH && k <= most + 2; k++) {
        line l;
        if (at + k * step < 0 || at + k * step >= count)
            break;
        some[k] = g[at + k * step];
        if (k && fit(some, k + 1, &l) && goes_through(&l, some, k + 1))
            most = k + 1, *out = l;
    }
    return most;
}

static void project(const line *l, double *x, double *y)
{
    double d = offset(l, *x, *y);
    *x += l->dy * d;
    *y -= l->dx * d;
}

static pv_cell to_grid(const sketch *s, double x, double y)
{
    return (pv_cell){ s->x * PV_GRID + (int32_t)floor(x * PV_GRID + 0.5),
                      s->y * PV_GRID + (int32_t)floor(y * PV_GRID + 0.5) };
}

static void from_grid(const sketch *s, pv_cell p, double *x, double *y)
{
    *x = (double)(p.x - s->x * PV_GRID) / PV_GRID;
    *y = (double)(p.y - s->y * PV_GRID) / PV_GRID;
}

static double limit(double v, double low, double high)
{
    return v < low ? low : v < high ? v : high;
}

static void raw_place(const sketch *s, int32_t x, int32_t y, double *px, double *py)
{
    *px = (double)(s->left + x) / s->place->scale;
    *py = (double)(s->top + y) / s->place->scale;
}

/* The ways from a junction that go along the contour. */
static int contour_ways(const pv_net *net, int32_t j, int32_t *ways)
{
    int count = 0;
    for (int32_t way = 0; way < PV_WAYS; way += 2) {
        int32_t left, right;
        if (net->exits[PV_WAYS * (int64_t)j + way] < 0)
            continue;
        colours_ahead(net, net->x[j], net->y[j], way, &left, &right);
        if (left != right && left >= 0 && right >= 0)
            ways[count++] = way;
    }
    return count;
}

/* Gates around a junction: those of the second way backwards, then those of the first. Returns where the middle is. */
static int32_t gates_around(const sketch *s, int32_t j, const int32_t *ways, gate *out, int32_t *count, int *between)
{
    gate back[REACH + 1];
    int32_t x = s->net->x[j], y = s->net->y[j];
    int32_t before = follow(s, x, y, ways[1], REACH + 1, back), first = before;
    int32_t after = follow(s, x, y, ways[0], REACH + 1, out + before);
    *between = !(before && after && same_gate(&back[0], &out[before]));
    if (!*between) { /* the junction is within a crack */
        memmove(out + before - 1, out + before, (size_t)after * sizeof *out);
        first--;
    }
    for (int32_t i = 0; i < first; i++)
        out[i] = back[before - 1 - i];
    *count = first + after;
    return first;
}

/* A corner of the contour. */
typedef struct bend {
    int32_t gate;  /* it lies before */
    int32_t right; /* it turns that way */
    double sharp, x, y;
} bend;

/* No corner is between two gates in a row, or side by side. */
static int goes_straight(const gate *a, const gate *b)
{
    return a->upright == b->upright && (a->crack == b->crack || (a->upright ? a->y == b->y : a->x == b->x));
}

/* A corner between gates i-1 and i of all: how sharp, and where. 0: none. */
static double corner_before(const gate *g, int32_t count, int32_t i, bend *out)
{
    line a = { 0, 0, 0, 0 }, b = a;
    if (i < 2 || i + 2 > count || goes_straight(&g[i - 1], &g[i]))
        return 0;
    int32_t back = line_from(g, count, i - 1, -1, &a), on = line_from(g, count, i, 1, &b);
    double cosine = -(a.dx * b.dx + a.dy * b.dy), cross = a.dx * b.dy - a.dy * b.dx;
    if (back < 2 || on < 2 || cosine > (back > 2 && on > 2 ? 0.85 : 0.5))
        return 0;
    /* the lattice point that both cracks end at */
    double px = g[i].upright ? g[i].crack : g[i - 1].upright ? g[i - 1].crack : (g[i].x + g[i - 1].x) / 2;
    double py = !g[i].upright ? g[i].crack : !g[i - 1].upright ? g[i - 1].crack : (g[i].y + g[i - 1].y) / 2;
    double t = fabs(cross) > 1e-3 ? ((b.x - a.x) * b.dy - (b.y - a.y) * b.dx) / cross : 0;
    int known = fabs(cross) > 1e-3;
    *out = (bend){ i, cross < 0, (back + on) * (1 - cosine), known ? limit(a.x + t * a.dx, px - 0.7, px + 0.7) : px,
                   known ? limit(a.y + t * a.dy, py - 0.7, py + 0.7) : py };
    return out->sharp;
}

/* Is the joint at a junction on the left of the contour that comes from the second way and goes on by the first? */
static int joint_is_left(const pv_net *net, int32_t j, const int32_t *ways)
{
    for (int32_t way = 0; way < PV_WAYS; way++)
        if (net->exits[PV_WAYS * (int64_t)j + way] >= 0 && way != ways[0] && way != ways[1])
            return ((way - ways[0]) & 7) < ((ways[1] - ways[0]) & 7);
    return 0;
}

static double square(double x, double y)
{
    return x * x + y * y;
}

enum { NEAR = 1 }; /* px: no bend is so near to a junction */

/* Is a corner, so many gates along a way from a junction, on the chain that begins there, and not nearer to its other
 * end? */
static int is_nearest(const sketch *s, int32_t j, int32_t way, int32_t gates, double far, const bend *b)
{
    const pv_net *net = s->net;
    int32_t half = net->exits[PV_WAYS * (int64_t)j + way];
    const pv_chain *c = &net->chain[half >> 1];
    int32_t other = half & 1 ? c->from : c->to;
    double x, y;
    raw_place(s, net->x[other], net->y[other], &x, &y);
    double far_too = square(b->x - x, b->y - y);
    return gates * s->place->scale <= c->length && other != j && (far < far_too || (far == far_too && j < other));
}

/* The corner that a junction goes to: a near one where the joint would otherwise leave a stone with a dent, or one
 * where it already is. */
static int corner_near(const sketch *s, int32_t j, const int32_t *ways, const gate *g, int32_t count, int32_t middle,
                       bend *out)
{
    int left = joint_is_left(s->net, j, ways);
    double least = 1e300, x, y;
    raw_place(s, s->net->x[j], s->net->y[j], &x, &y);
    *out = (bend){ 0, 0, 0, x, y };
    for (int32_t i = middle - REACH / 2; i <= middle + REACH / 2; i++) {
        bend b;
        if (i < 1 || i >= count || corner_before(g, count, i, &b) <= 0)
            continue;
        double far = square(b.x - x, b.y - y), most = b.right == left ? s->slide * s->slide : NEAR * NEAR;
        int32_t way = ways[i <= middle], gates = i <= middle ? middle - i : i - middle;
        if (far < most && far < least && is_nearest(s, j, way, gates, far, &b))
            least = far, *out = b;
    }
    return least < 1e300;
}

static void place_inner(const sketch *s, int32_t j, const int32_t *ways, double *x, double *y)
{
    gate g[2 * REACH + 2];
    int32_t count;
    int between;
    line l;
    int32_t middle = gates_around(s, j, ways, g, &count, &between);
    double rx = *x, ry = *y;
    bend corner;
    if (corner_near(s, j, ways, g, count, middle, &corner)) {
        *x = corner.x;
        *y = corner.y;
        return;
    }
    if (line_at(g, count, middle, between, &l)) {
        project(&l, x, y);
        *x = limit(*x, rx - 0.5, rx + 0.5);
        *y = limit(*y, ry - 0.5, ry + 0.5);
    }
}

/* Where the contour meets the border. */
static void place_rim(const sketch *s, int32_t j, int32_t way, double *x, double *y)
{
    gate g[REACH];
    line l;
    int32_t count = follow(s, s->net->x[j], s->net->y[j], way, REACH, g);
    if (line_from(g, count, 0, 1, &l) < 2)
        return;
    int32_t w = s->net->pieces->width;
    int upright = s->net->x[j] == 0 || s->net->x[j] == w; /* the border is */
    if (upright && fabs(l.dx) > 0.3)
        *y = limit(l.y + l.dy / l.dx * (*x - l.x), *y - 0.5, *y + 0.5);
    if (!upright && fabs(l.dy) > 0.3)
        *x = limit(l.x + l.dx / l.dy * (*y - l.y), *x - 0.5, *x + 0.5);
}

static void place_junction(sketch *s, int32_t j)
{
    const pv_net *net = s->net;
    int32_t x = net->x[j], y = net->y[j], ways[PV_WAYS], scale = s->place->scale, pinch = net->pinch[j];
    int border = x == 0 || y == 0 || x == net->pieces->width || y == net->pieces->height;
    int count = contour_ways(net, j, ways), rough = 0;
    double px, py;
    set_origin(s, j);
    raw_place(s, x, y, &px, &py);
    for (int32_t way = 0; way < PV_WAYS; way++) {
        int32_t half = net->exits[PV_WAYS * (int64_t)j + way];
        rough |= half >= 0 && s->out->rough[half >> 1] > 1;
    }
    if (pinch >= 0) {
        px += (pinch == 1 || pinch == 7 ? 0.125 : -0.125) / scale;
        py += (pinch == 5 || pinch == 7 ? 0.125 : -0.125) / scale;
    } else if (!rough && !border && count == 2) {
        place_inner(s, j, ways, &px, &py);
    } else if (!rough && border && count == 1) {
        place_rim(s, j, ways[0], &px, &py);
    }
    s->out->junction[j] = to_grid(s, px, py);
    s->out->kind[j] = (uint8_t)((border ? PV_BORDER : 0) | (count ? PV_CONTOUR : 0));
}

static pave_result add_bend(sketch *s, int64_t *count, pv_cell p)
{
    pave_result result = PAVE_OK;
    if (*count == s->out->room) {
        int64_t room = 2 * s->out->room + 1024;
        pv_cell *grown =
            pv_resize(s->context, s->out->bend, (size_t)s->out->room, (size_t)room, sizeof *grown, &result);
        if (result)
            return result;
        s->out->bend = grown;
        s->out->room = room;
    }
    s->out->bend[(*count)++] = p;
    return PAVE_OK;
}

static pave_result read_path(sketch *s, const pv_chain *c)
{
    pave_result result = PAVE_OK;
    if (c->length + 1 > s->path_room) {
        pv_release(s->xy);
        s->path_room = 2 * c->length + 64;
        s->xy = pv_allocate(s->context, 2 * (size_t)s->path_room, sizeof *s->xy, &result);
        s->path_room = s->xy ? s->path_room : 0;
    }
    if (!result)
        pv_net_path(s->net, c, s->xy);
    return result;
}

/* All points of the chain, or only its middle. */
static pave_result add_rough(sketch *s, const pv_chain *c, int all, int64_t *count)
{
    pave_result result = read_path(s, c);
    for (int32_t i = all ? 1 : c->length / 2; i < c->length && i && !result; i += all ? 1 : c->length) {
        double x, y;
        raw_place(s, s->xy[2 * i], s->xy[2 * i + 1], &x, &y);
        result = add_bend(s, count, to_grid(s, x, y));
    }
    return result;
}

static int32_t way_between(const int32_t *xy)
{
    return xy[2] > xy[0] ? 0 : xy[2] < xy[0] ? 4 : xy[3] < xy[1] ? 2 : 6;
}

static int32_t other_contour_way(const sketch *s, int32_t j, int32_t way)
{
    int32_t ways[PV_WAYS];
    if (s->net->pinch[j] >= 0 || contour_ways(s->net, j, ways) != 2)
        return -1;
    return ways[0] == way ? ways[1] : ways[0];
}

/* The gates of a chain with some before and after it. */
static pave_result read_gates(sketch *s, const pv_chain *c)
{
    gate some[REACH];
    pave_result result = read_path(s, c);
    int32_t need = c->length + 2 * REACH + 2;
    if (!result && need > s->room) {
        pv_release(s->gates);
        s->room = 2 * need;
        s->gates = pv_allocate(s->context, (size_t)s->room, sizeof *s->gates, &result);
        s->room = s->gates ? s->room : 0;
    }
    if (result)
        return result;
    int32_t way = other_contour_way(s, c->from, c->out), n = 0, before = 0;
    if (way >= 0)
        before = follow(s, s->net->x[c->from], s->net->y[c->from], way, REACH, some);
    for (int32_t i = before - 1; i >= 0; i--)
        s->gates[n++] = some[i];
    s->before = n;
    for (int32_t i = 0; i < c->length; i++) {
        gate g = gate_of(s, s->xy[2 * i], s->xy[2 * i + 1], way_between(s->xy + 2 * i));
        if (!n || !same_gate(&g, &s->gates[n - 1]))
            s->gates[n] = g, find_edge(s, &s->gates[n++]);
        else if (i == 0)
            s->before--;
    }
    s->count = n - s->before;
    way = other_contour_way(s, c->to, c->in);
    int32_t after = way < 0 ? 0 : follow(s, s->net->x[c->to], s->net->y[c->to], way, REACH, some);
    for (int32_t i = 0; i < after; i++)
        if (i || !same_gate(&some[0], &s->gates[n - 1]))
            s->gates[n++] = some[i];
    s->total = n;
    return PAVE_OK;
}

enum { APART = 3 };

/* The next corner of the chain from gate `from` on, the sharpest around; 0 if there is none. */
static int next_corner(const sketch *s, int32_t from, bend *out)
{
    out->sharp = 0;
    for (int32_t i = from + 1; i < s->before + s->count && (out->sharp <= 0 || i - out->gate < APART); i++) {
        bend b = { 0, 0, 0, 0, 0 };
        if (corner_before(s->gates, s->total, i, &b) > out->sharp)
            *out = b;
    }
    return out->sharp > 0;
}

/* A stretch of the contour between two places. */
typedef struct stretch {
    double ax, ay, bx, by;
    int32_t from, to; /* gates */
} stretch;

/* The gate that the straight way misses most, not right at an end; -1: it misses none. */
static int32_t worst_gate(const sketch *s, const stretch *w)
{
    double dx = w->bx - w->ax, dy = w->by - w->ay, length = sqrt(square(dx, dy)), worst = 0;
    line l = { w->ax, w->ay, length > 0 ? dx / length : 1, length > 0 ? dy / length : 0 };
    int32_t at = -1;
    for (int32_t i = w->from; i < w->to; i++) {
        const gate *g = &s->gates[i];
        double m = miss(&l, g, 0.45);
        if (m > worst && square(g->x - w->ax, g->y - w->ay) > 1 && square(g->x - w->bx, g->y - w->by) > 1)
            worst = m, at = i;
    }
    return at;
}

/* Bends between two places so that all gates between are gone through: at the worst one, and so on. */
static pave_result add_between(sketch *s, stretch w, int depth, int64_t *count)
{
    int32_t at = worst_gate(s, &w);
    if (at < 0 || depth > 40)
        return PAVE_OK;
    double x = s->gates[at].x, y = s->gates[at].y;
    line tangent;
    if (line_at(s->gates, s->total, at, 0, &tangent))
        project(&tangent, &x, &y);
    if (square(x - w.ax, y - w.ay) < 0.5 || square(x - w.bx, y - w.by) < 0.5)
        return PAVE_OK;
    stretch before = { w.ax, w.ay, x, y, w.from, at }, after = { x, y, w.bx, w.by, at + 1, w.to };
    pave_result result = add_between(s, before, depth + 1, count);
    if (!result)
        result = add_bend(s, count, to_grid(s, x, y));
    return result ? result : add_between(s, after, depth + 1, count);
}

static pave_result add_contour(sketch *s, const pv_chain *c, int64_t *count)
{
    bend corner = { 0, 0, 0, 0, 0 };
    pave_result result = read_gates(s, c);
    if (result)
        return result;
    stretch w = { 0, 0, 0, 0, s->before, 0 };
    double ex, ey;
    from_grid(s, s->out->junction[c->from], &w.ax, &w.ay);
    from_grid(s, s->out->junction[c->to], &ex, &ey);
    for (int32_t seen = w.from; !result && next_corner(s, seen, &corner); seen = corner.gate + APART - 1) {
        if (square(corner.x - w.ax, corner.y - w.ay) < NEAR || square(corner.x - ex, corner.y - ey) < NEAR)
            continue;
        w.bx = corner.x, w.by = corner.y, w.to = corner.gate;
        result = add_between(s, w, 0, count);
        if (!result)
            result = add_bend(s, count, to_grid(s, corner.x, corner.y));
        w.ax = w.bx, w.ay = w.by, w.from = w.to;
    }
    w.bx = ex, w.by = ey, w.to = s->before + s->count;
    return result ? result : add_between(s, w, 0, count);
}

static int is_contour(const pv_pieces *p, const pv_chain *c)
{
    return c->length && c->left >= 0 && c->right >= 0 && p->colour[c->left] != p->colour[c->right];
}

pave_result pv_outline_redraw(pave_context *context, const pv_net *net, const pv_tess_place *place, pv_outline *out)
{
    sketch s = { .context = context, .net = net, .place = place, .out = out, .slide = place->slide };
    pave_result result = PAVE_OK;
    int64_t count = 0;
    for (int32_t j = 0; j < net->junction_count; j++)
        place_junction(&s, j);
    for (int32_t c = 0; c < net->chain_count && !result; c++) {
        out->first[c] = count;
        set_origin(&s, net->chain[c].from);
        if (out->rough[c])
            result = add_rough(&s, &net->chain[c], out->rough[c] > 1, &count);
        else if (is_contour(net->pieces, &net->chain[c]))
            result = add_contour(&s, &net->chain[c], &count);
        if (!result && c % 4096 == 0)
            result = pv_progress(context, 0.12 + 0.1 * c / net->chain_count);
    }
    out->first[net->chain_count] = count;
    pv_release(s.gates);
    pv_release(s.xy);
    return result;
}

pave_result pv_outline_draw(pave_context *context, const pv_net *net, const pv_tess_place *place, pv_outline *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->junction = pv_allocate(context, (size_t)net->junction_count, sizeof *out->junction, &result);
    if (!result)
        out->kind = pv_allocate(context, (size_t)net->junction_count, sizeof *out->kind, &result);
    if (!result)
        out->first = pv_allocate(context, (size_t)net->chain_count + 1, sizeof *out->first, &result);
    if (!result)
        out->rough = pv_allocate_zeroed(context, (size_t)net->chain_count, sizeof *out->rough, &result);
    return result ? result : pv_outline_redraw(context, net, place, out);
}

void pv_outline_free(pv_outline *outline)
{
    pv_release(outline->junction);
    pv_release(outline->kind);
    pv_release(outline->first);
    pv_release(outline->bend);
    pv_release(outline->rough);
    memset(outline, 0, sizeof *outline);
}
