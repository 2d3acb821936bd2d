/* Sites into buckets: a counting sort whose parts run side by side. Each part has its own share of the indices and its
 * own counters, so that the sites of a bucket lie in index order whatever the number of parts. */
#include "backend/cpu.h"

#include "base/parallel.h"
#include "util/fixed.h"

#include <string.h>

enum { BLOCK = 1 << 15 /* buckets that get their places together */ };

static int32_t part_begin(const pv_cpu *cpu, int32_t part)
{
    return (int32_t)((int64_t)cpu->plane.sites * part / cpu->parts);
}

static uint32_t bucket_of(const pv_cpu *cpu, const pave_site *site)
{
    uint32_t side = (uint32_t)cpu->bucket;
    return (uint32_t)site->y / side * (uint32_t)cpu->across + (uint32_t)site->x / side;
}

static void count_part(void *data, int32_t part, int32_t worker)
{
    (void)worker;
    pv_cpu *cpu = data;
    int32_t *count = cpu->place + part * cpu->buckets, to = part_begin(cpu, part + 1);
    memset(count, 0, (size_t)cpu->buckets * sizeof *count);
    for (int32_t i = part_begin(cpu, part); i < to; i++)
        count[bucket_of(cpu, &cpu->sites[i])]++;
}

static int64_t block_end(const pv_cpu *cpu, int32_t block)
{
    int64_t end = ((int64_t)block + 1) * BLOCK;
    return end < cpu->buckets ? end : cpu->buckets;
}

static void count_block(void *data, int32_t block, int32_t worker)
{
    (void)worker;
    pv_cpu *cpu = data;
    int32_t sum = 0;
    for (int32_t part = 0; part < cpu->parts; part++)
        for (int64_t b = (int64_t)block * BLOCK; b < block_end(cpu, block); b++)
            sum += cpu->place[part * cpu->buckets + b];
    cpu->block_first[block] = sum;
}

/* From counts to places: bucket by bucket, and in it part by part. */
static void place_block(void *data, int32_t block, int32_t worker)
{
    (void)worker;
    pv_cpu *cpu = data;
    int32_t at = cpu->block_first[block];
    for (int64_t b = (int64_t)block * BLOCK; b < block_end(cpu, block); b++) {
        cpu->first[b] = at;
        for (int32_t part = 0; part < cpu->parts; part++) {
            int32_t *place = &cpu->place[part * cpu->buckets + b], count = *place;
            *place = at;
            at += count;
        }
    }
}

/* Extents are cut to 15 bits, slopes have 16. */
static void set_column(const pv_columns *c, int32_t at, const pave_site *s, int32_t most)
{
    int32_t a = s->half_x < most ? s->half_x : most, b = s->half_y < most ? s->half_y : most;
    c->x[at] = s->x;
    c->y[at] = s->y;
    c->cosine[at] = s->cosine;
    c->sine[at] = s->sine;
    c->box[at] = (int32_t)((uint32_t)b << 16 | (uint32_t)a);
}

static void fill_part(void *data, int32_t part, int32_t worker)
{
    (void)worker;
    pv_cpu *cpu = data;
    int32_t *place = cpu->place + part * cpu->buckets, to = part_begin(cpu, part + 1);
    int32_t most = cpu->plane.metric == PAVE_METRIC_BOX ? 32767 : 65535;
    for (int32_t i = part_begin(cpu, part); i < to; i++) {
        int32_t at = place[bucket_of(cpu, &cpu->sites[i])]++;
        cpu->index[at] = i;
        if (cpu->sorted)
            cpu->sorted[at] = cpu->sites[i];
        else
            set_column(&cpu->columns, at, &cpu->sites[i], most);
    }
}

static void add_up_blocks(pv_cpu *cpu, int32_t blocks)
{
    int32_t sum = 0;
    for (int32_t block = 0; block < blocks; block++) {
        int32_t count = cpu->block_first[block];
        cpu->block_first[block] = sum;
        sum += count;
    }
}

int32_t pv_cpu_blocks(int64_t buckets)
{
    return (int32_t)pv_ceil_div(buckets, BLOCK);
}

pave_result pv_cpu_sort(pave_context *context, pv_cpu *cpu, double at)
{
    int32_t blocks = pv_cpu_blocks(cpu->buckets);
    pave_result result = pv_parallel(context, cpu->parts, count_part, cpu, at, at);
    if (!result)
        result = pv_parallel(context, blocks, count_block, cpu, at, at);
    if (!result) {
        add_up_blocks(cpu, blocks);
        result = pv_parallel(context, blocks, place_block, cpu, at, at);
    }
    return result ? result : pv_parallel(context, cpu->parts, fill_part, cpu, at, at);
}
