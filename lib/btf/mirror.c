/* The sample as mirrors show it, where they keep views and lights: other pieces of its class, to learn from. What is
 * mirrored is seen through the sample's own eigen-ABRDFs. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <string.h>

/* turn[i][k]: what the k-th eigen-ABRDF of a plane, mirrored, shows of the i-th. */
static pave_result find_turn(const pv_enlarge *e, int32_t element, int32_t plane, float *turn)
{
    const pv_factors *f = &e->out->factors[plane];
    const int32_t *view = e->symmetry.view[element], *light = e->symmetry.light[element];
    int32_t n = f->components, lights = e->out->lights.count;
    int64_t pairs = pv_btf_rows(e->out);
    pave_result result = PAVE_OK;
    float *mirrored = pv_allocate(e->context, (size_t)pairs, (size_t)n * sizeof *mirrored, &result);
    for (int64_t p = 0; p < pairs && !result; p++)
        memcpy(mirrored + p * n, f->left + ((int64_t)view[p / lights] * lights + light[p % lights]) * n,
               (size_t)n * sizeof *mirrored);
    if (!result)
        pv_multiply(&e->algebra, 1, 0, n, n, (int)pairs, f->left, n, mirrored, n, 0, turn, n);
    pv_release(mirrored);
    return result;
}

typedef struct mirroring {
    const pv_enlarge *e;
    int32_t element;
    float *turn[PV_BTF_CHANNELS];
    pv_texels *out;
} mirroring;

static void mirror_texel(void *data, int32_t texel, int32_t worker)
{
    (void)worker;
    const mirroring *m = data;
    const pv_enlarge *e = m->e;
    const float *from = e->known.values + pv_mirrored_texel(e, m->element, texel) * e->coefficients;
    float *to = m->out->values + (int64_t)texel * e->coefficients;
    for (int32_t c = 0; c < e->planes; c++) {
        int32_t first = e->first[c], n = e->first[c + 1] - first;
        for (int32_t i = 0; i < n; i++) {
            float sum = 0;
            for (int32_t k = 0; k < n; k++)
                sum += m->turn[c][i * n + k] * from[first + k];
            to[first + i] = sum;
        }
    }
}

static pave_result mirror_known(pv_enlarge *e, int32_t element, pv_texels *out)
{
    mirroring m = { .e = e, .element = element, .out = out };
    pave_result result = pv_texels_new(e->context, e->known.width, e->known.height, e->coefficients, out);
    for (int32_t c = 0; c < e->planes && !result; c++) {
        size_t n = (size_t)(e->first[c + 1] - e->first[c]);
        m.turn[c] = pv_allocate(e->context, n, n * sizeof *m.turn[c], &result);
        if (!result)
            result = find_turn(e, element, c, m.turn[c]);
    }
    if (!result)
        result = pv_parallel(e->context, (int32_t)pv_texels_count(out), mirror_texel, &m, 0, 0);
    for (int32_t c = 0; c < e->planes; c++)
        pv_release(m.turn[c]);
    return result;
}

pave_result pv_enlarge_mirror(pv_enlarge *e)
{
    pave_result result = PAVE_OK;
    e->known_mirrored[0] = e->known;
    e->seen_mirrored[0] = e->seen;
    for (int32_t i = 1; i < e->symmetry.count && !result; i++) {
        result = mirror_known(e, i, &e->known_mirrored[i]);
        if (!result)
            result = pv_enlarge_see(e, i, &e->seen_mirrored[i]);
    }
    return result;
}
