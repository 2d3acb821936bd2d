/* The sample turned and mirrored, where that takes views to views and lights to lights: other pieces of its class, to
 * learn from. What they show is seen through the sample's own eigen-ABRDFs. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* ---- Which there are ---- */

static const double root_of_3_by_2 = 0.86602540378443864676;

/* The k-th multiple of 30 degrees, of a mirror image from 12 on: a matrix across the plane, y towards the top. */
static void find_move(int32_t k, double across[4])
{
    const double sine[12] = { 0, 0.5, root_of_3_by_2, 1, root_of_3_by_2, 0.5, 0, -0.5, -root_of_3_by_2, -1,
                              -root_of_3_by_2, -0.5 };
    double c = sine[(k + 3) % 12], s = sine[k % 12], side = k < 12 ? 1 : -1;
    across[0] = side * c;
    across[1] = -s;
    across[2] = side * s;
    across[3] = c;
}

/* Texels are counted downwards. */
static void to_texels(const double across[4], double place[4])
{
    place[0] = across[0];
    place[1] = -across[1];
    place[2] = -across[2];
    place[3] = across[3];
}

static pave_result try_move(pv_enlarge *e, const double across[4])
{
    const pv_directions *views = &e->sample->views, *lights = &e->sample->lights;
    pv_turned *copy = &e->copy[e->copies];
    pave_result result = PAVE_OK;
    copy->view = pv_allocate(e->context, (size_t)views->count, sizeof *copy->view, &result);
    if (!result)
        copy->light = pv_allocate(e->context, (size_t)lights->count, sizeof *copy->light, &result);
    if (!result && pv_directions_moved(views, across, copy->view) && pv_directions_moved(lights, across, copy->light)) {
        to_texels(across, copy->place);
        e->copies++;
        return result;
    }
    pv_release(copy->view);
    pv_release(copy->light);
    copy->view = copy->light = NULL;
    return result;
}

static pave_result find_copies(pv_enlarge *e)
{
    int32_t wanted = e->params->mode == PAVE_BTF_BEST && e->params->symmetric ? PV_MOST_COPIES : 1;
    pave_result result = PAVE_OK;
    for (int32_t skew = 0; skew < 2; skew++) {
        for (int32_t k = 0; k < wanted && !result; k++) {
            double across[4];
            find_move(k, across);
            if ((k % 3 != 0) == skew)
                result = try_move(e, across);
        }
        if (!skew)
            e->straight = e->copies;
    }
    return result;
}

/* ---- What they show ---- */

/* turn[i][k]: what the k-th eigen-ABRDF of a plane, as it is in the copy, shows of the i-th. */
static pave_result find_turn(const pv_enlarge *e, const pv_turned *copy, int32_t plane, float *turn)
{
    const pv_factors *f = &e->out->factors[plane];
    int32_t n = f->components, lights = e->out->lights.count;
    int64_t pairs = pv_btf_rows(e->out);
    pave_result result = PAVE_OK;
    float *moved = pv_allocate(e->context, (size_t)pairs, (size_t)n * sizeof *moved, &result);
    for (int64_t p = 0; p < pairs && !result; p++)
        memcpy(moved + p * n, f->left + ((int64_t)copy->view[p / lights] * lights + copy->light[p % lights]) * n,
               (size_t)n * sizeof *moved);
    if (!result)
        pv_multiply(&e->algebra, 1, 0, n, n, (int)pairs, f->left, n, moved, n, 0, turn, n);
    pv_release(moved);
    return result;
}

void pv_enlarge_copied(const pv_enlarge *e, const pv_turned *copy, int64_t texel, float *out)
{
    const float *from = e->known.values + texel * e->coefficients;
    for (int32_t c = 0; c < e->planes; c++) {
        int32_t first = e->first[c], n = e->first[c + 1] - first;
        if (!copy->turn[c])
            memcpy(out + first, from + first, (size_t)n * sizeof *out);
        for (int32_t i = 0; i < n && copy->turn[c]; i++) {
            float sum = 0;
            for (int32_t k = 0; k < n; k++)
                sum += copy->turn[c][i * n + k] * from[first + k];
            out[first + i] = sum;
        }
    }
}

static pave_result fill_copy(const pv_enlarge *e, pv_turned *copy)
{
    pave_result result = pv_enlarge_see(e, copy, &copy->seen);
    for (int32_t c = 0; c < e->planes && !result && copy != e->copy; c++) {
        size_t n = (size_t)(e->first[c + 1] - e->first[c]);
        copy->turn[c] = pv_allocate(e->context, n, n * sizeof *copy->turn[c], &result);
        if (!result)
            result = find_turn(e, copy, c, copy->turn[c]);
    }
    return result;
}

pave_result pv_enlarge_copy(pv_enlarge *e)
{
    pave_result result = find_copies(e);
    for (int32_t i = 0; i < e->copies && !result; i++)
        result = fill_copy(e, &e->copy[i]);
    e->seen = e->copy[0].seen;
    return result;
}

void pv_enlarge_free_copies(pv_enlarge *e)
{
    for (int32_t i = 0; i < e->copies; i++) {
        pv_release(e->copy[i].view);
        pv_release(e->copy[i].light);
        pv_release(e->copy[i].seen.values);
        for (int32_t c = 0; c < PV_BTF_CHANNELS; c++)
            pv_release(e->copy[i].turn[c]);
    }
}
