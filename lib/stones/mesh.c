/* The faces of an outline, ring by ring. */
#include "stones/contour.h"

#include <string.h>

static int64_t corners_of(const pv_net *net, const pv_outline *outline)
{
    int64_t count = 0;
    for (int32_t c = 0; c < net->chain_count; c++)
        count += (1 + outline->first[c + 1] - outline->first[c]) *
                 ((net->chain[c].left >= 0) + (net->chain[c].right >= 0));
    return count;
}

static pave_result allocate(pave_context *context, const pv_net *net, const pv_outline *outline, pv_tess *out)
{
    pave_result result = PAVE_OK;
    int64_t vertices = net->junction_count + outline->first[net->chain_count];
    size_t faces = (size_t)net->pieces->count;
    if (vertices > INT32_MAX)
        return pv_fail(context, PAVE_ERR_LIMIT, "%lld corners of stones are too many", (long long)vertices);
    out->vertex_count = (int32_t)vertices;
    out->face_count = net->pieces->count;
    out->at = pv_allocate(context, (size_t)vertices, sizeof *out->at, &result);
    if (!result)
        out->kind = pv_allocate(context, (size_t)vertices, sizeof *out->kind, &result);
    if (!result)
        out->flat = pv_allocate(context, (size_t)vertices, sizeof *out->flat, &result);
    if (!result)
        out->first = pv_allocate_zeroed(context, faces + 1, sizeof *out->first, &result);
    if (!result)
        out->corner = pv_allocate(context, (size_t)corners_of(net, outline), sizeof *out->corner, &result);
    if (!result)
        out->label = pv_allocate(context, faces, sizeof *out->label, &result);
    if (!result)
        out->part = pv_allocate(context, faces, sizeof *out->part, &result);
    if (!result)
        out->colour = pv_allocate(context, faces, sizeof *out->colour, &result);
    return result;
}

static void set_vertices(const pv_net *net, const pv_outline *outline, pv_tess *out)
{
    int32_t n = net->junction_count;
    for (int32_t j = 0; j < n; j++) {
        out->at[j] = outline->junction[j];
        out->kind[j] = outline->kind[j];
    }
    for (int32_t c = 0; c < net->chain_count; c++) {
        const pv_chain *k = &net->chain[c];
        int border = k->left < 0 || k->right < 0;
        int contour = !border && net->pieces->colour[k->left] != net->pieces->colour[k->right];
        for (int64_t b = outline->first[c]; b < outline->first[c + 1]; b++) {
            out->at[n + b] = outline->bend[b];
            out->kind[n + b] = (uint8_t)(PV_BEND | (border ? PV_BORDER : 0) | (contour ? PV_CONTOUR : 0));
        }
    }
    memset(out->flat, -1, (size_t)out->vertex_count * sizeof *out->flat);
}

/* The vertices of a half chain without its end; only counted if `corner` is NULL. */
static int64_t put_half(const pv_net *net, const pv_outline *outline, int32_t half, int32_t *corner)
{
    const pv_chain *c = &net->chain[half >> 1];
    int64_t first = outline->first[half >> 1], count = outline->first[(half >> 1) + 1] - first;
    if (!corner)
        return 1 + count;
    *corner++ = half & 1 ? c->to : c->from;
    for (int64_t i = 0; i < count; i++)
        corner[i] = (int32_t)(net->junction_count + first + (half & 1 ? count - 1 - i : i));
    return 1 + count;
}

/* Each piece has one ring, for it has no holes and does not touch itself. */
static pave_result set_rings(pave_context *context, const pv_net *net, const pv_outline *outline, pv_tess *out)
{
    pave_result result = PAVE_OK;
    int32_t *start = pv_allocate(context, (size_t)out->face_count, sizeof *start, &result);
    for (int32_t f = 0; f < out->face_count && !result; f++)
        start[f] = -1;
    for (int32_t h = 0; h < 2 * net->chain_count && !result; h++) {
        int32_t f = pv_net_left(net, h);
        if (f >= 0 && start[f] < 0)
            start[f] = h;
    }
    for (int32_t f = 0; f < out->face_count && !result; f++) {
        int64_t at = out->first[f];
        int32_t h = start[f];
        do {
            at += put_half(net, outline, h, out->corner + at);
            h = pv_net_next(net, h);
        } while (h != start[f]);
        out->first[f + 1] = at;
    }
    pv_release(start);
    if (!result && out->first[out->face_count] != corners_of(net, outline))
        result = pv_fail(context, PAVE_ERR_INTERNAL, "a piece has more than one ring");
    return result;
}

static pave_result assemble(pave_context *context, const pv_net *net, const pv_tess_place *place,
                            const pv_outline *outline, pv_tess *out)
{
    memset(out, 0, sizeof *out);
    out->period = (pv_cell){ place->period.x * PV_GRID, place->period.y * PV_GRID };
    pave_result result = allocate(context, net, outline, out);
    if (result)
        return result;
    size_t faces = (size_t)out->face_count;
    memcpy(out->label, net->pieces->label, faces * sizeof *out->label);
    memcpy(out->part, net->pieces->part, faces * sizeof *out->part);
    memcpy(out->colour, net->pieces->colour, faces * sizeof *out->colour);
    set_vertices(net, outline, out);
    return set_rings(context, net, outline, out);
}

/* Makes all chains of invalid faces rougher; tells how many were not as rough as can be. */
static pave_result find_crossings(pave_context *context, const pv_net *net, const pv_tess *tess, pv_outline *outline,
                                  int64_t *found)
{
    pave_result result = PAVE_OK;
    int32_t longest = 1;
    for (int32_t f = 0; f < tess->face_count; f++)
        longest = pv_tess_size(tess, f) > longest ? pv_tess_size(tess, f) : longest;
    pv_cell *ring = pv_allocate(context, (size_t)longest, sizeof *ring, &result);
    uint8_t *bad = result ? NULL : pv_allocate_zeroed(context, (size_t)tess->face_count, 1, &result);
    for (int32_t f = 0; f < tess->face_count && !result; f++)
        bad[f] = !pv_ring_valid(ring, pv_tess_ring(tess, f, ring, longest));
    *found = 0;
    for (int32_t c = 0; c < net->chain_count && !result; c++) {
        const pv_chain *k = &net->chain[c];
        if (outline->rough[c] > 1 || !((k->left >= 0 && bad[k->left]) || (k->right >= 0 && bad[k->right])))
            continue;
        outline->rough[c]++;
        ++*found;
    }
    pv_release(bad);
    pv_release(ring);
    return result;
}

static pave_result build(pave_context *context, const pv_net *net, const pv_tess_place *place, pv_outline *outline,
                         pv_tess *out)
{
    int64_t found = 1;
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    while (found && !result) {
        pv_tess_free(out);
        result = assemble(context, net, place, outline, out);
        if (!result)
            result = find_crossings(context, net, out, outline, &found);
        if (!result && found)
            result = pv_outline_redraw(context, net, place, outline);
    }
    return result ? result : pv_tess_index(context, out);
}

pave_result pv_tess_trace(pave_context *context, const pv_pieces *pieces, const pv_tess_place *place, pv_tess *out)
{
    pv_net net = { 0 };
    pv_outline outline = { 0 };
    pave_result result = pv_net_trace(context, pieces, &net);
    if (!result)
        result = pv_outline_draw(context, &net, place, &outline);
    if (!result)
        result = build(context, &net, place, &outline, out);
    pv_outline_free(&outline);
    pv_net_free(&net);
    return result;
}
