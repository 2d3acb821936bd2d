/* Boxes in buckets: a grid about as fine as there are boxes, so that each meets few others. */
#include "stones/measure.h"

#include <math.h>
#include <string.h>

pv_box pv_box_of(const pv_cell *ring, int32_t count)
{
    pv_box box = { ring[0].x, ring[0].y, ring[0].x, ring[0].y };
    for (int32_t i = 1; i < count; i++) {
        box.left = ring[i].x < box.left ? ring[i].x : box.left;
        box.right = ring[i].x > box.right ? ring[i].x : box.right;
        box.top = ring[i].y < box.top ? ring[i].y : box.top;
        box.bottom = ring[i].y > box.bottom ? ring[i].y : box.bottom;
    }
    return box;
}

static int32_t place(int64_t offset, int32_t side, int32_t count)
{
    return offset < 0 ? 0 : offset / side < count ? (int32_t)(offset / side) : count - 1;
}

int32_t pv_bucket_column(const pv_buckets *buckets, int32_t x)
{
    return place((int64_t)x - buckets->left, buckets->side, buckets->columns);
}

int32_t pv_bucket_row(const pv_buckets *buckets, int32_t y)
{
    return place((int64_t)y - buckets->top, buckets->side, buckets->rows);
}

/* As many buckets as boxes, roughly, over the stones' window. */
static void lay_out(const pave_stones *plane, int32_t count, pv_buckets *out)
{
    double ground = (double)plane->width * plane->height;
    double side = ceil(sqrt(ground / (count ? count : 1)) * PV_GRID);
    double longest = (plane->width > plane->height ? plane->width : plane->height) * (double)PV_GRID;
    side = fmax(side, ceil(longest / (4.0 * count + 64))); /* a long and narrow plane has few buckets, too */
    out->left = plane->x * PV_GRID;
    out->top = plane->y * PV_GRID;
    out->side = (int32_t)fmin(side, 1 << 30);
    out->columns = (int32_t)((double)plane->width * PV_GRID / out->side) + 1;
    out->rows = (int32_t)((double)plane->height * PV_GRID / out->side) + 1;
}

/* Counts a box in its buckets, or with `member` sets it there: first[b] is then where the next one goes. */
static void visit(const pv_buckets *b, const pv_box *box, int32_t i, int32_t *member)
{
    int32_t left = pv_bucket_column(b, box->left), right = pv_bucket_column(b, box->right);
    int32_t top = pv_bucket_row(b, box->top), bottom = pv_bucket_row(b, box->bottom);
    for (int32_t row = top; row <= bottom; row++)
        for (int32_t column = left; column <= right; column++) {
            int64_t *at = &b->first[(int64_t)row * b->columns + column];
            if (member)
                member[(*at)++] = i;
            else
                at[1]++;
        }
}

static pave_result visit_all(pave_context *context, const pv_buckets *b, const pv_box *box, int32_t count,
                             int32_t *member)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < count && !result; i++) {
        visit(b, &box[i], i, member);
        if (i % 4096 == 0)
            result = pv_progress(context, 0);
    }
    return result;
}

pave_result pv_buckets_fill(pave_context *context, const pave_stones *plane, const pv_box *box, int32_t count,
                            pv_buckets *out)
{
    pave_result result;
    memset(out, 0, sizeof *out);
    lay_out(plane, count, out);
    int64_t buckets = (int64_t)out->columns * out->rows;
    out->first = pv_allocate_zeroed(context, (size_t)buckets + 1, sizeof *out->first, &result);
    if (!out->first)
        return result;
    result = visit_all(context, out, box, count, NULL);
    for (int64_t b = 0; b < buckets; b++)
        out->first[b + 1] += out->first[b];
    if (!result)
        out->member = pv_allocate(context, (size_t)out->first[buckets], sizeof *out->member, &result);
    if (!result)
        result = visit_all(context, out, box, count, out->member);
    memmove(out->first + 1, out->first, (size_t)buckets * sizeof *out->first);
    out->first[0] = 0;
    return result;
}

void pv_buckets_free(pv_buckets *buckets)
{
    pv_release(buckets->first);
    pv_release(buckets->member);
    memset(buckets, 0, sizeof *buckets);
}
