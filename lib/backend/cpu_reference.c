/* The definition: every site for every pixel, the lowest index among equals. */
#include "backend/cpu.h"
#include "backend/metric.h"
#include "util/fixed.h"

static int32_t nearest(const pv_cpu *cpu, int32_t x, int32_t y, uint64_t *distance)
{
    int32_t best = 0;
    uint64_t least = UINT64_MAX;
    for (int32_t i = 0; i < cpu->plane.sites; i++) {
        uint64_t d = pv_metric(cpu->plane.metric, &cpu->sites[i], x, y);
        if (d < least)
            least = d, best = i;
    }
    *distance = least;
    return best;
}

int32_t pv_label_row_reference(const pv_cpu *cpu, int32_t ty, pv_sum *sums, int32_t *labels)
{
    int32_t bottom = (ty + 1) * PV_TILE < cpu->plane.height ? (ty + 1) * PV_TILE : cpu->plane.height;
    uint64_t farthest = 0;
    for (int32_t y = ty * PV_TILE; y < bottom; y++)
        for (int32_t x = 0; x < cpu->plane.width; x++) {
            uint64_t d;
            int32_t label = nearest(cpu, 256 * x + 128, 256 * y + 128, &d);
            farthest = d > farthest && pv_watched(cpu, x / PV_TILE * PV_TILE, ty * PV_TILE) ? d : farthest;
            if (!pv_masked(&cpu->plane, x, y))
                pv_sum_add(&sums[label], 1, x, y);
            if (labels)
                labels[(int64_t)y * cpu->plane.width + x] = label;
        }
    return pv_cpu_range(cpu, pv_isqrt(farthest) + 1 + PV_METRIC_SLACK);
}
