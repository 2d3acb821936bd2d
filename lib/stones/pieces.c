/* From labels to pieces: runs of equal pixels, joined row by row; slivers merged; cuts through holes. */
#include "stones/pieces.h"

#include <stdlib.h>
#include <string.h>

/* Pixels x .. up to the next run of the row. */
typedef struct run {
    int32_t x, piece;
    int64_t key; /* what belongs together has the same */
} run;

typedef struct work {
    pave_context *context;
    int32_t width, height, pieces;
    int64_t *row; /* where each row's runs begin; height + 1 */
    run *runs;
    int64_t *parent;
    int64_t *key, *area; /* of pieces */
} work;

static int32_t run_end(const work *w, int32_t y, int64_t r)
{
    return r + 1 < w->row[y + 1] ? w->runs[r + 1].x : w->width;
}

static void expand_colours(const pv_label_image *image, int32_t y, uint8_t *row)
{
    const uint8_t *from = image->colours + (int64_t)((y + image->colour_y) / image->scale) * image->colour_width;
    int32_t at = image->colour_x / image->scale, left = image->scale - image->colour_x % image->scale;
    for (int32_t x = 0; x < image->width; x++) {
        row[x] = from[at];
        if (!--left)
            at++, left = image->scale;
    }
}

static int64_t count_runs(const int32_t *labels, const uint8_t *colours, int32_t width)
{
    int32_t count = 1;
    for (int32_t x = 1; x < width; x++)
        count += (labels[x] != labels[x - 1]) | (colours[x] != colours[x - 1]);
    return count;
}

static void find_runs(const int32_t *labels, const uint8_t *colours, int32_t width, run *out)
{
    for (int32_t x = 0; x < width; x++)
        if (!x || labels[x] != labels[x - 1] || colours[x] != colours[x - 1])
            *out++ = (run){ x, 0, (int64_t)labels[x] * 256 + colours[x] };
}

static pave_result read_runs(work *w, const pv_label_image *image)
{
    pave_result result = PAVE_OK;
    uint8_t *colours = pv_allocate_zeroed(w->context, (size_t)w->width, 1, &result);
    if (result)
        return result;
    for (int pass = 0; pass < 2 && !result; pass++) {
        for (int32_t y = 0; y < w->height && !result; y++) {
            if (image->colours)
                expand_colours(image, y, colours);
            const int32_t *labels = image->labels + (int64_t)y * image->stride;
            if (pass)
                find_runs(labels, colours, w->width, w->runs + w->row[y]);
            else
                w->row[y + 1] = w->row[y] + count_runs(labels, colours, w->width);
            if (y % 256 == 0)
                result = pv_progress(w->context, 0.02 * (pass + (double)y / w->height));
        }
        if (!pass && !result)
            w->runs = pv_allocate(w->context, (size_t)w->row[w->height], sizeof *w->runs, &result);
    }
    pv_release(colours);
    return result;
}

static int64_t root_of(int64_t *parent, int64_t r)
{
    while (parent[r] != r)
        r = parent[r] = parent[parent[r]];
    return r;
}

static void join(int64_t *parent, int64_t a, int64_t b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

typedef void pair_visit(work *w, int64_t a, int64_t b, int64_t length, void *data);

/* Every two runs that touch along a side, with the length of their contact. */
static void visit_pairs(work *w, int sideways, pair_visit *visit, void *data)
{
    for (int32_t y = 0; y < w->height; y++) {
        for (int64_t r = w->row[y] + 1; sideways && r < w->row[y + 1]; r++)
            visit(w, r - 1, r, 1, data);
        if (!y)
            continue;
        int64_t a = w->row[y - 1], b = w->row[y];
        while (a < w->row[y] && b < w->row[y + 1]) {
            int32_t ea = run_end(w, y - 1, a), eb = run_end(w, y, b);
            int32_t from = w->runs[a].x > w->runs[b].x ? w->runs[a].x : w->runs[b].x, to = ea < eb ? ea : eb;
            visit(w, a, b, to - from, data);
            a += ea == to;
            b += eb == to;
        }
    }
}

static void join_equal(work *w, int64_t a, int64_t b, int64_t length, void *data)
{
    (void)length, (void)data;
    if (w->runs[a].key == w->runs[b].key)
        join(w->parent, a, b);
}

/* Numbers the connected sets of runs with equal keys by their first run. */
static pave_result find_pieces(work *w)
{
    pave_result result = PAVE_OK;
    int64_t count = w->row[w->height];
    pv_release(w->parent);
    pv_release(w->key);
    pv_release(w->area);
    w->key = w->area = NULL;
    w->parent = pv_allocate(w->context, (size_t)count, sizeof *w->parent, &result);
    if (result)
        return result;
    for (int64_t r = 0; r < count; r++)
        w->parent[r] = r;
    visit_pairs(w, 1, join_equal, NULL);
    w->pieces = 0;
    for (int64_t r = 0; r < count; r++)
        w->runs[r].piece = root_of(w->parent, r) == r ? w->pieces++ : w->runs[w->parent[r]].piece;
    w->key = pv_allocate(w->context, (size_t)w->pieces, sizeof *w->key, &result);
    if (!result)
        w->area = pv_allocate_zeroed(w->context, (size_t)w->pieces, sizeof *w->area, &result);
    for (int32_t y = 0; y < w->height && !result; y++)
        for (int64_t r = w->row[y]; r < w->row[y + 1]; r++) {
            w->key[w->runs[r].piece] = w->runs[r].key;
            w->area[w->runs[r].piece] += run_end(w, y, r) - w->runs[r].x;
        }
    return result;
}

/* How a small piece touches another one. */
typedef struct contact {
    int32_t small, other;
    int64_t length;
} contact;

typedef struct contacts {
    int64_t least;
    int fill;
    int64_t count;
    contact *list; /* NULL: only count */
} contacts;

static void add_contact(contacts *c, int32_t small, int32_t other, int64_t length)
{
    if (c->list)
        c->list[c->count] = (contact){ small, other, length };
    c->count++;
}

static void note_contact(work *w, int64_t a, int64_t b, int64_t length, void *data)
{
    contacts *c = data;
    int32_t p = w->runs[a].piece, q = w->runs[b].piece;
    if (p == q || (w->area[p] >= c->least && w->area[q] >= c->least) ||
        (!c->fill && (w->key[p] & 255) != (w->key[q] & 255)))
        return;
    if (w->area[p] < c->least)
        add_contact(c, p, q, length);
    if (w->area[q] < c->least)
        add_contact(c, q, p, length);
}

static int by_pair(const void *a, const void *b)
{
    const contact *p = a, *q = b;
    return p->small != q->small ? (p->small > q->small) - (p->small < q->small)
                                : (p->other > q->other) - (p->other < q->other);
}

/* The neighbour that each small piece has the longest contact with; the larger, then the first among equals. */
static void choose_targets(const work *w, const contacts *c, int32_t *target)
{
    int64_t best = 0;
    for (int64_t i = 0, j; i < c->count; i = j) {
        int64_t length = 0;
        for (j = i; j < c->count && !by_pair(&c->list[i], &c->list[j]); j++)
            length += c->list[j].length;
        int32_t small = c->list[i].small, other = c->list[i].other, now = target[small];
        if (now < 0 || length > best || (length == best && w->area[other] > w->area[now])) {
            target[small] = other;
            best = length;
        }
        if (j < c->count && c->list[j].small != small)
            best = 0;
    }
}

/* Into pieces that stay as they are, or two small ones into the first of them. */
static void merge_into_targets(work *w, int64_t least, int32_t *target)
{
    for (int32_t p = 0; p < w->pieces; p++) {
        int32_t q = target[p];
        if (q < 0)
            continue;
        int stays = w->area[q] >= least || (target[q] == p && q < p);
        target[p] = stays ? q : -1 - q;
    }
    for (int32_t p = 0; p < w->pieces; p++)
        if (target[p] >= 0)
            w->key[p] = w->key[target[p]];
    for (int64_t r = 0; r < w->row[w->height]; r++) {
        int32_t p = w->runs[r].piece;
        w->runs[r].key = w->key[p];
        if (target[p] >= 0)
            w->runs[r].piece = target[p];
    }
}

/* One key a piece; touching runs of a row with one key become one. */
static void compact(work *w)
{
    int64_t at = 0, begin = 0;
    for (int32_t y = 0; y < w->height; y++) {
        int64_t end = w->row[y + 1], first = at;
        for (int64_t r = begin; r < end; r++)
            if (at == first || w->runs[at - 1].piece != w->runs[r].piece)
                w->runs[at++] = w->runs[r];
        begin = end;
        w->row[y + 1] = at;
    }
}

static pave_result merge_once(work *w, int64_t least, int fill, int64_t *merged)
{
    pave_result result = PAVE_OK;
    contacts c = { least, fill, 0, NULL };
    visit_pairs(w, 1, note_contact, &c);
    *merged = c.count;
    if (!c.count)
        return PAVE_OK;
    int32_t *target = pv_allocate(w->context, (size_t)w->pieces, sizeof *target, &result);
    if (!result)
        c.list = pv_allocate(w->context, (size_t)c.count, sizeof *c.list, &result);
    if (!result) {
        c.count = 0;
        visit_pairs(w, 1, note_contact, &c);
        qsort(c.list, (size_t)c.count, sizeof *c.list, by_pair);
        memset(target, -1, (size_t)w->pieces * sizeof *target);
        choose_targets(w, &c, target);
        merge_into_targets(w, least, target);
        compact(w);
    }
    pv_release(c.list);
    pv_release(target);
    return result;
}

/* A piece's own key from now on: pieces of one label and colour that touch only here stay apart. */
static void key_by_piece(work *w, int32_t *label_of, uint8_t *colour_of)
{
    for (int64_t r = 0; r < w->row[w->height]; r++) {
        label_of[w->runs[r].piece] = (int32_t)(w->key[w->runs[r].piece] >> 8);
        colour_of[w->runs[r].piece] = (uint8_t)(w->key[w->runs[r].piece] & 255);
    }
}

static void count_edge(work *w, int64_t a, int64_t b, int64_t length, void *data)
{
    int32_t *cycles = data;
    (void)length;
    if (w->runs[a].piece == w->runs[b].piece)
        cycles[w->runs[a].piece]++;
}

/* Where to cut pieces with holes, for runs of pieces are a graph whose cycles are the holes: through the middle of
 * their first gap, which is that of the hole or of another dent, or else through their own middle. 0: nowhere. */
static int64_t find_cuts(work *w, int32_t *cycles, int32_t *cut)
{
    int64_t cuts = 0;
    memset(cycles, 0, (size_t)w->pieces * sizeof *cycles);
    memset(cut, 0, (size_t)w->pieces * sizeof *cut);
    visit_pairs(w, 0, count_edge, cycles);
    for (int64_t r = 0; r < w->row[w->height]; r++)
        cycles[w->runs[r].piece]--;
    for (int32_t p = 0; p < w->pieces; p++)
        cycles[p] = cycles[p] >= 0 ? -1 : INT32_MIN; /* now: where the piece's last run ended, if it is to be cut */
    for (int32_t y = 0; y < w->height; y++) {
        for (int64_t r = w->row[y]; r < w->row[y + 1]; r++) {
            int32_t p = w->runs[r].piece, end = run_end(w, y, r);
            if (cycles[p] == INT32_MIN || cut[p])
                continue;
            if (cycles[p] >= 0)
                cut[p] = (cycles[p] + w->runs[r].x + 1) / 2, cuts++;
            cycles[p] = end;
        }
        for (int64_t r = w->row[y]; r < w->row[y + 1]; r++)
            if (cycles[w->runs[r].piece] >= 0)
                cycles[w->runs[r].piece] = -1;
    }
    return cuts;
}

/* Splits runs at their piece's cut and gives each side a key of its own. */
static pave_result apply_cuts(work *w, const int32_t *cut)
{
    pave_result result = PAVE_OK;
    int64_t count = 0, begin = 0;
    run *runs = pv_allocate(w->context, 2 * (size_t)w->row[w->height], sizeof *runs, &result);
    for (int32_t y = 0; y < w->height && !result; y++) {
        int64_t end = w->row[y + 1], first = count;
        for (int64_t r = begin; r < end; r++) {
            int32_t x = w->runs[r].x, to = r + 1 < end ? w->runs[r + 1].x : w->width, p = w->runs[r].piece;
            int64_t key = w->runs[r].key;
            runs[count++] = (run){ x, p, 2 * key + (cut[p] && x >= cut[p]) };
            if (x < cut[p] && cut[p] < to)
                runs[count++] = (run){ cut[p], p, 2 * key + 1 };
        }
        begin = end;
        w->row[y] = first;
    }
    if (result)
        return result;
    w->row[w->height] = count;
    pv_release(w->runs);
    w->runs = runs;
    return PAVE_OK;
}

typedef struct names {
    int32_t *label;
    uint8_t *colour;
} names;

static pave_result allocate_names(work *w, names *n)
{
    pave_result result = PAVE_OK;
    n->label = pv_allocate(w->context, (size_t)w->pieces, sizeof *n->label, &result);
    n->colour = result ? NULL : pv_allocate(w->context, (size_t)w->pieces, sizeof *n->colour, &result);
    return result;
}

static void free_names(names *n)
{
    pv_release(n->label);
    pv_release(n->colour);
    *n = (names){ NULL, NULL };
}

/* Finds pieces again after a change of keys, which are pieces of before, or halves of them. */
static pave_result find_again(work *w, names *n, int halves)
{
    names old = *n;
    pave_result result = find_pieces(w);
    *n = (names){ NULL, NULL };
    if (!result)
        result = allocate_names(w, n);
    for (int32_t p = 0; p < w->pieces && !result; p++) {
        int64_t before = w->key[p] >> halves;
        n->label[p] = old.label[before];
        n->colour[p] = old.colour[before];
    }
    free_names(&old);
    return result;
}

static void keys_from_pieces(work *w)
{
    for (int64_t r = 0; r < w->row[w->height]; r++)
        w->runs[r].key = w->runs[r].piece;
}

static pave_result cut_holes(work *w, names *n)
{
    pave_result result = PAVE_OK;
    for (int64_t cuts = 1; cuts && !result;) {
        int32_t *cycles = pv_allocate(w->context, (size_t)w->pieces, sizeof *cycles, &result);
        int32_t *cut = result ? NULL : pv_allocate(w->context, (size_t)w->pieces, sizeof *cut, &result);
        keys_from_pieces(w);
        cuts = result ? 0 : find_cuts(w, cycles, cut);
        if (cuts && !result)
            result = apply_cuts(w, cut);
        if (cuts && !result)
            result = find_again(w, n, 1);
        pv_release(cut);
        pv_release(cycles);
        if (!result)
            result = pv_progress(w->context, 0.05);
    }
    return result;
}

/* Merging renumbers pieces: by their own numbers they are found again. */
static pave_result merge_small(work *w, int64_t least, int fill)
{
    pave_result result = PAVE_OK;
    for (int round = 0; round < PV_PIECES_ROUNDS && !result; round++) {
        int64_t merged = 0;
        result = merge_once(w, least, fill && round == PV_PIECES_ROUNDS - 1, &merged);
        if (result || (!merged && !fill))
            break;
        if (!merged)
            continue;
        /* Pieces of one label and colour that were apart may touch now through a third: they stay one piece only if
         * they were merged. So keys carry the piece until all is found again. */
        int64_t *key = w->key;
        w->key = NULL;
        keys_from_pieces(w);
        result = find_pieces(w);
        for (int32_t p = 0; p < w->pieces && !result; p++)
            w->key[p] = key[w->key[p]];
        pv_release(key);
    }
    return result;
}

static pave_result number_and_paint(work *w, const names *n, int32_t label_count, pv_pieces *out)
{
    pave_result result = PAVE_OK;
    int32_t *place = pv_allocate_zeroed(w->context, (size_t)label_count + 1, sizeof *place, &result);
    int32_t *number = result ? NULL : pv_allocate(w->context, (size_t)w->pieces, sizeof *number, &result);
    for (int32_t p = 0; p < w->pieces && !result; p++)
        place[n->label[p] + 1]++;
    for (int32_t l = 0; l < label_count && !result; l++)
        place[l + 1] += place[l];
    for (int32_t p = 0; p < w->pieces && !result; p++) {
        int32_t f = number[p] = place[n->label[p]]++;
        out->label[f] = n->label[p];
        out->colour[f] = n->colour[p];
        out->area[f] = w->area[p];
    }
    for (int32_t f = 0; f < w->pieces && !result; f++)
        out->part[f] = f && out->label[f] == out->label[f - 1] ? out->part[f - 1] + 1 : 0;
    for (int32_t y = 0; y < w->height && !result; y++)
        for (int64_t r = w->row[y]; r < w->row[y + 1]; r++) {
            int32_t f = number[w->runs[r].piece], end = run_end(w, y, r), *row = out->face + (int64_t)y * w->width;
            for (int32_t x = w->runs[r].x; x < end; x++)
                row[x] = f;
        }
    pv_release(number);
    pv_release(place);
    return result;
}

static pave_result allocate_pieces(work *w, pv_pieces *out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)w->pieces;
    out->width = w->width;
    out->height = w->height;
    out->count = w->pieces;
    out->face = pv_allocate(w->context, (size_t)w->width * (size_t)w->height, sizeof *out->face, &result);
    if (!result)
        out->label = pv_allocate(w->context, n, sizeof *out->label, &result);
    if (!result)
        out->part = pv_allocate(w->context, n, sizeof *out->part, &result);
    if (!result)
        out->colour = pv_allocate(w->context, n, sizeof *out->colour, &result);
    if (!result)
        out->area = pv_allocate(w->context, n, sizeof *out->area, &result);
    return result;
}

pave_result pv_pieces_split(pave_context *context, const pv_label_image *image, int64_t least, int fill,
                            pv_pieces *out)
{
    pave_result result = PAVE_OK;
    work w = { .context = context, .width = image->width, .height = image->height };
    names n = { NULL, NULL };
    memset(out, 0, sizeof *out);
    w.row = pv_allocate_zeroed(context, (size_t)w.height + 1, sizeof *w.row, &result);
    if (!result)
        result = read_runs(&w, image);
    if (!result)
        result = find_pieces(&w);
    if (!result)
        result = merge_small(&w, least, fill);
    if (!result)
        result = allocate_names(&w, &n);
    if (!result) {
        key_by_piece(&w, n.label, n.colour);
        result = cut_holes(&w, &n);
    }
    if (!result)
        result = allocate_pieces(&w, out);
    if (!result)
        result = number_and_paint(&w, &n, image->label_count, out);
    free_names(&n);
    pv_release(w.row);
    pv_release(w.runs);
    pv_release(w.parent);
    pv_release(w.key);
    pv_release(w.area);
    return result;
}

void pv_pieces_free(pv_pieces *pieces)
{
    pv_release(pieces->face);
    pv_release(pieces->label);
    pv_release(pieces->part);
    pv_release(pieces->colour);
    pv_release(pieces->area);
    memset(pieces, 0, sizeof *pieces);
}
