/* Distances of neighbourhoods: whole numbers, so that every way to compute them gives the same. */
#include "solid/bank.h"

static void distances_portable(const pv_windows *bank, const int16_t *patch, const int16_t *presence,
                               const int32_t *positions, int32_t count, int32_t *out)
{
    int32_t stride = bank->window.stride;
    for (int32_t i = 0; i < count; i++) {
        const int16_t *theirs = bank->patch + (size_t)positions[i] * (size_t)stride;
        int32_t sum = 0;
        for (int32_t k = 0; k < stride; k++) {
            int16_t d = (int16_t)((theirs[k] - patch[k]) * presence[k]);
            sum += (int32_t)d * d;
        }
        out[i] = sum;
    }
}

pv_distances *pv_distances_choose(int32_t portable)
{
#ifdef PV_DISTANCE_AVX2
    __builtin_cpu_init();
    if (!portable && __builtin_cpu_supports("avx2"))
        return pv_distances_avx2;
#endif
    (void)portable;
    return distances_portable;
}
