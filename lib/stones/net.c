/* Junctions and chains of a raster of pieces. */
#include "stones/net.h"

#include "base/parallel.h"

#include <string.h>

static inline int32_t piece_at(const pv_pieces *p, int32_t x, int32_t y)
{
    return x < 0 || y < 0 || x >= p->width || y >= p->height ? -1 : p->face[(int64_t)y * p->width + x];
}

typedef struct corner {
    int32_t nw, ne, sw, se;
} corner;

static inline corner corner_at(const pv_pieces *p, int32_t x, int32_t y)
{
    return (corner){ piece_at(p, x - 1, y - 1), piece_at(p, x, y - 1), piece_at(p, x - 1, y), piece_at(p, x, y) };
}

static inline int cracks_of(corner c)
{
    return (c.nw != c.ne) + (c.sw != c.se) + (c.nw != c.sw) + (c.ne != c.se);
}

/* Junctions that a lattice point stands for: two where a piece touches itself across it. */
static inline int junctions_at(const pv_pieces *p, int32_t x, int32_t y)
{
    corner c = corner_at(p, x, y);
    int cracks = cracks_of(c), border = (x == 0 || x == p->width) && (y == 0 || y == p->height);
    if (cracks < 3)
        return border;
    return cracks == 4 && (c.nw == c.se || c.ne == c.sw) ? 2 : 1;
}

typedef struct job {
    pv_net *net;
    int fill;
} job;

static void add_junctions(pv_net *net, int32_t x, int32_t y, int count, int64_t at)
{
    corner c = corner_at(net->pieces, x, y);
    for (int k = 0; k < count; k++) {
        net->x[at + k] = x;
        net->y[at + k] = y;
        net->pinch[at + k] = (int8_t)(count == 1 ? -1 : c.nw == c.se ? (k ? 7 : 3) : (k ? 5 : 1));
    }
}

enum { STRETCH = 32 }; /* long enough to be a loop, which compilers make vectors of */

/* Is there none but a plain crack, or nothing, at the next lattice points? Without a branch, for junctions are rare. */
static inline int is_plain(const int32_t *up, const int32_t *down)
{
    int32_t crowded = 0;
    for (int32_t x = 0; x < STRETCH; x++) {
        int32_t across = (up[x - 1] == up[x]) + (down[x - 1] == down[x]);
        int32_t alike = across + (up[x - 1] == down[x - 1]) + (up[x] == down[x]);
        crowded += alike < 2 ? 1 : 0;
    }
    return !crowded;
}

static void scan_row(void *data, int32_t y, int32_t worker)
{
    const job *j = data;
    const pv_pieces *p = j->net->pieces;
    const int32_t *up = p->face + (int64_t)(y - 1) * p->width, *down = up + p->width;
    int inside = y > 0 && y < p->height;
    int64_t at = j->fill ? j->net->row[y] : 0;
    (void)worker;
    for (int32_t x = 0, end; x <= p->width; x = end) {
        end = x + STRETCH <= p->width ? x + STRETCH : p->width + 1;
        if (inside && x > 0 && end <= p->width && is_plain(up + x, down + x))
            continue;
        for (; x < end; x++) {
            int count = junctions_at(p, x, y);
            if (count && j->fill)
                add_junctions(j->net, x, y, count, at);
            at += count;
        }
    }
    if (!j->fill)
        j->net->row[y + 1] = at;
}

static pave_result find_junctions(pave_context *context, pv_net *net)
{
    int32_t rows = net->pieces->height + 1;
    pave_result result = PAVE_OK;
    job j = { net, 0 };
    net->row = pv_allocate_zeroed(context, (size_t)rows + 1, sizeof *net->row, &result);
    if (!result)
        result = pv_parallel(context, rows, scan_row, &j, 0.06, 0.07);
    if (result)
        return result;
    for (int32_t y = 0; y < rows; y++)
        net->row[y + 1] += net->row[y];
    if (net->row[rows] > INT32_MAX / 8)
        return pv_fail(context, PAVE_ERR_LIMIT, "%lld corners of stones are too many", (long long)net->row[rows]);
    net->junction_count = (int32_t)net->row[rows];
    size_t n = (size_t)net->junction_count;
    net->x = pv_allocate(context, n, sizeof *net->x, &result);
    if (!result)
        net->y = pv_allocate(context, n, sizeof *net->y, &result);
    if (!result)
        net->pinch = pv_allocate(context, n, sizeof *net->pinch, &result);
    if (!result)
        net->exits = pv_allocate(context, PV_WAYS * n, sizeof *net->exits, &result);
    if (!result)
        net->chain = pv_allocate(context, 2 * n, sizeof *net->chain, &result);
    j.fill = 1;
    return result ? result : pv_parallel(context, rows, scan_row, &j, 0.07, 0.08);
}

/* The pixels ahead on the left and on the right, going from lattice point (x, y). */
static inline void ahead(const pv_pieces *p, int32_t x, int32_t y, int32_t way, int32_t *left, int32_t *right)
{
    switch (way) {
    case 0: *left = piece_at(p, x, y - 1), *right = piece_at(p, x, y); break;
    case 2: *left = piece_at(p, x - 1, y - 1), *right = piece_at(p, x, y - 1); break;
    case 4: *left = piece_at(p, x - 1, y), *right = piece_at(p, x - 1, y - 1); break;
    default: *left = piece_at(p, x, y), *right = piece_at(p, x - 1, y);
    }
}

static inline void move(int32_t way, int32_t *x, int32_t *y)
{
    *x += (way == 0) - (way == 4);
    *y += (way == 6) - (way == 2);
}

/* Does this half of a pinch own the way? It has those on both sides of the piece that it points into. */
static inline int owns(const pv_net *net, int32_t junction, int32_t way)
{
    int32_t pinch = net->pinch[junction];
    return pinch < 0 || way == ((pinch + 1) & 7) || way == ((pinch + 7) & 7);
}

/* The junction at a lattice point that has a way; -1: none. */
static int32_t junction_at(const pv_net *net, int32_t x, int32_t y, int32_t way)
{
    int64_t low = net->row[y], high = net->row[y + 1];
    while (low < high) {
        int64_t middle = (low + high) / 2;
        if (net->x[middle] < x)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == net->row[y + 1] || net->x[low] != x)
        return -1;
    return (int32_t)(owns(net, (int32_t)low, way) ? low : low + 1);
}

static int32_t turn(const pv_pieces *p, int32_t x, int32_t y, int32_t way, const pv_chain *c)
{
    int32_t left, right;
    ahead(p, x, y, way, &left, &right);
    if (left != c->left)
        return (way + 2) & 7;
    return right != c->right ? (way + 6) & 7 : way;
}

static void walk(const pv_net *net, pv_chain *c)
{
    const pv_pieces *p = net->pieces;
    int32_t x = net->x[c->from], y = net->y[c->from], way = c->out;
    ahead(p, x, y, way, &c->left, &c->right);
    for (c->length = 1;; c->length++) {
        move(way, &x, &y);
        if (cracks_of(corner_at(p, x, y)) > 2 || ((x == 0 || x == p->width) && (y == 0 || y == p->height)))
            break;
        way = turn(p, x, y, way, c);
    }
    c->in = (way + 4) & 7;
    c->to = junction_at(net, x, y, c->in);
}

void pv_net_path(const pv_net *net, const pv_chain *chain, int32_t *xy)
{
    int32_t x = net->x[chain->from], y = net->y[chain->from], way = chain->out;
    for (int32_t i = 0; i <= chain->length; i++) {
        xy[2 * i] = x;
        xy[2 * i + 1] = y;
        if (i && i < chain->length)
            way = turn(net->pieces, x, y, way, chain);
        if (i < chain->length)
            move(way, &x, &y);
    }
}

static void add_chain(pv_net *net, int32_t junction, int32_t way)
{
    int32_t c = net->chain_count++;
    pv_chain *chain = &net->chain[c];
    *chain = (pv_chain){ .from = junction, .out = way };
    walk(net, chain);
    net->exits[PV_WAYS * (int64_t)junction + way] = 2 * c;
    net->exits[PV_WAYS * (int64_t)chain->to + chain->in] = 2 * c + 1;
}

/* The short chain between the halves of a pinch, which parts the piece there. */
static void add_bridge(pv_net *net, int32_t first)
{
    int32_t c = net->chain_count++, in = net->pinch[first], out = (in + 4) & 7;
    corner k = corner_at(net->pieces, net->x[first], net->y[first]);
    int32_t left = out == 7 ? k.ne : k.nw, right = out == 7 ? k.sw : k.se; /* going south-east, or south-west */
    net->chain[c] = out == 7 ? (pv_chain){ first, first + 1, out, in, left, right, 0 }
                             : (pv_chain){ first, first + 1, out, in, right, left, 0 };
    net->exits[PV_WAYS * (int64_t)first + out] = 2 * c;
    net->exits[PV_WAYS * (int64_t)(first + 1) + in] = 2 * c + 1;
}

static int has_crack(const pv_net *net, int32_t junction, int32_t way)
{
    int32_t left, right;
    ahead(net->pieces, net->x[junction], net->y[junction], way, &left, &right);
    return left != right;
}

pave_result pv_net_trace(pave_context *context, const pv_pieces *pieces, pv_net *out)
{
    memset(out, 0, sizeof *out);
    out->pieces = pieces;
    pave_result result = find_junctions(context, out);
    if (result)
        return result;
    memset(out->exits, -1, PV_WAYS * (size_t)out->junction_count * sizeof *out->exits);
    for (int32_t j = 0; j < out->junction_count && !result; j++) {
        for (int32_t way = 0; way < PV_WAYS; way += 2)
            if (out->exits[PV_WAYS * (int64_t)j + way] < 0 && owns(out, j, way) && has_crack(out, j, way))
                add_chain(out, j, way);
        if (out->pinch[j] == 1 || out->pinch[j] == 3)
            add_bridge(out, j);
        if (j % 4096 == 0)
            result = pv_progress(context, 0.08 + 0.04 * j / out->junction_count);
    }
    return result;
}

void pv_net_free(pv_net *net)
{
    pv_release(net->row);
    pv_release(net->x);
    pv_release(net->y);
    pv_release(net->pinch);
    pv_release(net->exits);
    pv_release(net->chain);
    memset(net, 0, sizeof *net);
}

int32_t pv_net_next(const pv_net *net, int32_t half)
{
    const pv_chain *c = &net->chain[half >> 1];
    int32_t at = half & 1 ? c->from : c->to, back = half & 1 ? c->out : c->in;
    const int32_t *exits = net->exits + PV_WAYS * (int64_t)at;
    for (int32_t k = 1; k <= PV_WAYS; k++) {
        int32_t next = exits[(back - k) & 7];
        if (next >= 0)
            return next;
    }
    return -1;
}
