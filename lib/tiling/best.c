/* Mode best: blocks laid over each other and cut; then, part by part, the worst seams cut again. A small canvas is laid
 * several times, and the best attempt goes on: what comes out varies from one to the next by more than what many rounds
 * gain. */
#include "tiling/best.h"

#include <string.h>

enum { SEAMS = 3 /* that a part's turn cuts again */, MOST_ATTEMPTS = 3, ROUNDS = 100, ROUNDS_OF_MANY = 36 };

/* The whole job. */
typedef struct job {
    pave_context *context;
    const pave_tiling_params *params;
    pv_scale scale;
    pv_attempt attempt[MOST_ATTEMPTS];
    int32_t attempts;
    int32_t workers;
    pv_worker *worker;
    int32_t across, down; /* parts */
    int32_t shift_x, shift_y, round, block;
} job;

/* A stretch of one side of the canvas: part i of `parts`. Between parts one or two pixels belong to none, so that what
 * one thread reads no other writes. */
static void stretch(int32_t size, int wraps, int32_t parts, int32_t shift, int32_t i, int32_t *from, int32_t *length)
{
    int32_t each = size / parts, end;
    if (!wraps && parts == 1) {
        *from = 0;
        *length = size;
        return;
    }
    *from = shift % each + i * each;
    end = *from + each - 2;
    if (!wraps && i == parts - 1) /* what is left over at both ends is the turn of other rounds */
        end = end < size ? end : size;
    *length = end - *from;
}

static pv_area part_at(const job *j, const pv_canvas *canvas, int32_t index)
{
    pv_area part;
    stretch(canvas->width, canvas->wrap_x, j->across, j->shift_x, index % j->across, &part.x, &part.width);
    stretch(canvas->height, canvas->wrap_y, j->down, j->shift_y, index / j->across, &part.y, &part.height);
    part.x = pv_wrapped(part.x, canvas->width);
    part.y = pv_wrapped(part.y, canvas->height);
    return part;
}

static void lay_block(void *data, int32_t index, int32_t worker)
{
    job *j = data;
    pv_worker_turn(&j->worker[worker], &j->attempt[index]);
    if (!pv_blocks_lay(&j->worker[worker], j->block))
        j->attempt[index].failed = 1;
}

static pave_result start(job *j, double to)
{
    pave_result result = PAVE_OK;
    int failed = 0;
    pv_worker_turn(&j->worker[0], &j->attempt[0]);
    int32_t blocks = pv_blocks_all(&j->worker[0]);
    for (j->block = 0; j->block < blocks && !result && !failed; j->block++) {
        result = pv_parallel(j->context, j->attempts, lay_block, j, to * j->block / blocks,
                             to * (j->block + 1) / blocks);
        for (int32_t i = 0; i < j->attempts; i++)
            failed |= j->attempt[i].failed;
    }
    if (!result && failed)
        return pv_fail(j->context, PAVE_ERR_ARGUMENT, "no usable block of %d x %d px in the exemplar",
                       (int)j->scale.block, (int)j->scale.block);
    return result;
}

/* Some of the worst seams of a part of an attempt, one after the other; prices are as they were before. */
static void mend(void *data, int32_t index, int32_t worker)
{
    job *j = data;
    pv_worker *w = &j->worker[worker];
    int32_t parts = j->across * j->down, least = 2 * j->scale.window / 3;
    uint32_t round = (uint32_t)j->round, at = (uint32_t)(index % parts);
    pv_worker_turn(w, &j->attempt[index / parts]);
    pv_area part = part_at(j, w->canvas, index % parts);
    int more = part.width >= least && part.height >= least;
    if (more) {
        pv_repeats_count(&w->repeats, part);
        pv_seams_find(w, part);
    }
    for (uint32_t k = 0; k < SEAMS && more; k++) {
        uint32_t turn = 1 + w->attempt->number * SEAMS + k;
        pv_random random = pv_draw(j->params->seed, PV_DRAW_ROUNDS, round, at, turn);
        more = pv_seams_mend(w, &random);
    }
}

static pave_result refine(job *j, int32_t rounds, double from, double to)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < rounds && !result; i++, j->round++) {
        pv_random random = pv_draw(j->params->seed, PV_DRAW_ROUNDS, (uint32_t)j->round, 0, 0);
        double a = from + (to - from) * i / rounds;
        j->shift_x = (int32_t)pv_below(random.word[0], 1 << 20);
        j->shift_y = (int32_t)pv_below(random.word[1], 1 << 20);
        for (int32_t k = 0; k < j->attempts; k++)
            pv_coverage_count(&j->attempt[k].coverage, &j->attempt[k].canvas);
        result = pv_parallel(j->context, j->attempts * j->across * j->down, mend, j, a, a + (to - from) / rounds);
    }
    return result;
}

static int32_t parts_of(int32_t size, int32_t reach)
{
    int32_t parts = size / (reach + reach / 2);
    return parts > 1 ? parts : 1;
}

/* The first attempt is laid on the canvas itself. */
static pave_result make_attempt(job *j, const pv_canvas *canvas, uint32_t number)
{
    pv_attempt *a = &j->attempt[number];
    size_t n = (size_t)canvas->width * (size_t)canvas->height;
    pave_result result = PAVE_OK;
    *a = (pv_attempt){ .canvas = *canvas, .number = number };
    if (number)
        a->canvas.source = pv_allocate(j->context, n, sizeof *canvas->source, &result);
    if (!result && number)
        memcpy(a->canvas.source, canvas->source, n * sizeof *canvas->source);
    if (!result)
        a->fails = pv_allocate_zeroed(j->context, n, 1, &result);
    if (!result)
        result = pv_coverage_create(j->context, canvas->bank, j->params->coverage, &a->coverage);
    return result;
}

static void free_attempt(pv_attempt *a)
{
    pv_coverage_free(&a->coverage);
    pv_release(a->fails);
    if (a->number)
        pv_release(a->canvas.source);
    a->canvas.source = NULL;
    a->fails = NULL;
}

static pave_result prepare(job *j, const pv_canvas *canvas)
{
    pave_result result = PAVE_OK;
    j->across = parts_of(canvas->width, j->scale.reach);
    j->down = parts_of(canvas->height, j->scale.reach);
    j->scale.part_width = canvas->width / j->across;
    j->scale.part_height = canvas->height / j->down;
    j->attempts = j->across * j->down == 1 && !j->params->wang ? MOST_ATTEMPTS : 1;
    for (int32_t i = 0; i < j->attempts && !result; i++)
        result = make_attempt(j, canvas, (uint32_t)i);
    j->workers = pv_workers(j->context);
    if (!result)
        j->worker = pv_allocate_zeroed(j->context, (size_t)j->workers, sizeof *j->worker, &result);
    for (int32_t i = 0; i < j->workers && !result; i++)
        result = pv_worker_create(j->context, j->params, &j->scale, &j->attempt[0], &j->worker[i]);
    return result;
}

/* Goes on with the attempt whose seams cost least, on the canvas. */
static void choose_attempt(job *j)
{
    int32_t best = 0;
    for (int32_t i = 0; i < j->attempts; i++) {
        pv_attempt *a = &j->attempt[i];
        pv_worker_turn(&j->worker[0], a);
        a->cost = pv_seams_cost(&j->worker[0], part_at(j, &a->canvas, 0));
        best = a->cost < j->attempt[best].cost ? i : best;
    }
    pv_attempt *first = &j->attempt[0], *chosen = &j->attempt[best];
    size_t n = (size_t)first->canvas.width * (size_t)first->canvas.height;
    if (best) {
        memcpy(first->canvas.source, chosen->canvas.source, n * sizeof *first->canvas.source);
        memcpy(first->fails, chosen->fails, n);
    }
    while (j->attempts > 1)
        free_attempt(&j->attempt[--j->attempts]);
}

static pave_result run(job *j)
{
    int32_t rounds = j->params->rounds ? j->params->rounds : j->across * j->down > 1 ? ROUNDS_OF_MANY : ROUNDS;
    int32_t first = j->attempts > 1 ? (rounds + 2) / MOST_ATTEMPTS : 0;
    pave_result result = start(j, j->attempts > 1 ? 0.2 : 0.1);
    if (!result)
        result = refine(j, first, 0.2, 0.6);
    if (!result && j->attempts > 1)
        choose_attempt(j);
    return result ? result : refine(j, rounds - first, first ? 0.6 : 0.1, 1);
}

pave_result pv_best_lay(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                        pv_canvas *canvas)
{
    job j = { .context = context, .params = params, .scale = *scale };
    pave_result result = prepare(&j, canvas);
    if (!result)
        result = run(&j);
    for (int32_t i = 0; i < j.workers && j.worker; i++)
        pv_worker_free(&j.worker[i]);
    pv_release(j.worker);
    for (int32_t i = 0; i < MOST_ATTEMPTS; i++)
        free_attempt(&j.attempt[i]);
    return result;
}
