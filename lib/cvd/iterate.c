/* The iterations: an engine moves the sites step by step, in a region that shrinks on the way.
 *
 * Each step leaves less of a region as it is in the whole plane. What is lost would be computed for nothing; when it
 * has come to enough, the engine is closed and another one goes on without. */
#include "cvd/cvd.h"

#include <string.h>

enum { FIELD_ROUNDING = 512 };

/* What an engine is given, and how far it has come. */
typedef struct job {
    pave_context *context;
    const pv_backend *backend;
    pv_plane *plane;
    pv_seeds *seeds;
    uint16_t *edge;
    pave_cvd *cvd;
    int32_t lacking; /* from the plane's reach to the greatest there may be elsewhere, 1/256 px */
    int fixed, done; /* fixed: the region is not to shrink */
} job;

/* Some pixels around what is wanted keep their sites, so that they do not seem farther away than they are. */
static int32_t kept(const job *j)
{
    return 2 * j->plane->cell + FIELD_ROUNDING;
}

/* How much of the region along open borders is lost, px. */
static int32_t spare(const job *j)
{
    int32_t lost = j->cvd->exact - kept(j);
    return j->plane->open && !j->plane->copies && lost > 0 ? lost >> 8 : 0;
}

/* What is left: less what is lost along open borders, and no more beyond the others than may still be needed. */
static pv_rect rest(const job *j)
{
    const pave_cvd *cvd = j->cvd;
    int32_t cut = spare(j), open = j->plane->open;
    int32_t past = pv_margin_guess(&cvd->params, 0) - pv_margin_guess(&cvd->params, cvd->steps);
    pv_rect r = pv_region_rect(cvd), wanted = pv_rect_grown(cvd->window, cvd->reserve - past + (kept(j) >> 8), r);
    int32_t left = open & PV_LEFT ? r.x + cut : wanted.x, top = open & PV_TOP ? r.y + cut : wanted.y;
    int32_t right = open & PV_RIGHT ? r.x + r.width - cut : wanted.x + wanted.width;
    int32_t bottom = open & PV_BOTTOM ? r.y + r.height - cut : wanted.y + wanted.height;
    return (pv_rect){ left, top, right - left, bottom - top };
}

static int is_in(const job *j, const pave_site *site, pv_rect r)
{
    int32_t x = site->x - 256 * (r.x - j->cvd->place.x), y = site->y - 256 * (r.y - j->cvd->place.y);
    return x >= 0 && y >= 0 && x < 256 * r.width && y < 256 * r.height;
}

/* Is it worth while? */
static int pays(const job *j, pv_rect r)
{
    const pave_cvd *cvd = j->cvd;
    return !j->fixed && !j->plane->copies && r.width > 0 && r.height > 0 && pv_rect_room(cvd->window, r, cvd) >= 0 &&
           4 * (int64_t)r.width * r.height <= 3 * (int64_t)cvd->width * cvd->height;
}

/* Does nothing get lost that belongs to the window? */
static int keeps_window(const job *j, pv_rect r)
{
    int32_t kept = 0;
    for (int32_t i = 0; i < j->cvd->site_count; i++) {
        int in = is_in(j, &j->cvd->sites[i], r);
        if (!in && j->cvd->mine[i])
            return 0;
        kept += in;
    }
    return kept > 0;
}

static void keep_sites(job *j, pv_rect r)
{
    pave_cvd *cvd = j->cvd;
    int32_t n = 0;
    for (int32_t i = 0; i < cvd->site_count; i++) {
        if (!is_in(j, &cvd->sites[i], r))
            continue;
        j->seeds->sites[n] = cvd->sites[i];
        j->seeds->sites[n].x -= 256 * (r.x - cvd->place.x);
        j->seeds->sites[n].y -= 256 * (r.y - cvd->place.y);
        j->seeds->homes[n] = j->seeds->homes[i];
        cvd->numbers[n] = cvd->numbers[i];
        cvd->mine[n] = cvd->mine[i];
        if (cvd->shifts)
            cvd->shifts[n] = cvd->shifts[i];
        n++;
    }
    cvd->site_count = j->seeds->count = j->plane->sites = n;
}

static void keep_edges(job *j, pv_rect r)
{
    const pave_cvd *cvd = j->cvd;
    const uint16_t *from = j->edge + (int64_t)(r.y - cvd->place.y) * cvd->width + r.x - cvd->place.x;
    for (int64_t y = 0; y < r.height && j->edge; y++)
        memmove(j->edge + y * r.width, from + y * cvd->width, (size_t)r.width * sizeof *from);
}

/* From where the sites are now on, in what is left of the region. */
static void shrink(job *j)
{
    pave_cvd *cvd = j->cvd;
    int32_t cut = spare(j);
    pv_rect r = rest(j);
    j->fixed = !keeps_window(j, r);
    if (j->fixed) {
        memcpy(j->seeds->sites, cvd->sites, (size_t)cvd->site_count * sizeof *cvd->sites);
        return;
    }
    if (j->edge)
        keep_edges(j, r);
    keep_sites(j, r);
    cvd->place.x = r.x;
    cvd->place.y = r.y;
    cvd->width = j->plane->width = r.width;
    cvd->height = j->plane->height = r.height;
    j->plane->origin_x = 256 * r.x;
    j->plane->origin_y = 256 * r.y;
    cvd->exact = j->plane->open ? cvd->exact - 256 * cut : 0;
    cvd->exact = cvd->exact > FIELD_ROUNDING ? cvd->exact : FIELD_ROUNDING;
    j->plane->open = pv_region_open(cvd, r);
}

static pave_result step(job *j, void *engine)
{
    pave_cvd *cvd = j->cvd;
    const pv_plane *plane = j->plane;
    double share = 1.0 / (cvd->params.iterations + 1);
    int32_t i = cvd->steps, least = plane->copies ? 0 : plane->cell;
    int32_t wrong = plane->copies ? cvd->stray + plane->cell + plane->cell / 2 : cvd->exact + least;
    pv_step s = { .deep = wrong >> 8 };
    pave_result result = j->backend->step(j->context, engine, i, i * share, (i + 1) * share, &s);
    int32_t radius = s.radius + j->lacking;
    cvd->exact = pv_margin_after(plane, cvd->exact, radius > least ? radius : least);
    cvd->far = radius > cvd->far ? radius : cvd->far;
    cvd->stray = s.stray > cvd->stray ? s.stray : cvd->stray;
    cvd->movement = (double)s.way / (plane->copies ? pv_torus_sites(cvd) : plane->sites) / 256;
    cvd->steps = i + 1;
    return result;
}

static int is_done(const pave_cvd *cvd)
{
    return cvd->steps >= cvd->params.iterations ||
           (cvd->steps && cvd->movement <= cvd->params.until_still && cvd->params.until_still > 0);
}

static pave_result label(job *j, void *engine)
{
    pave_cvd *cvd = j->cvd;
    pave_result result = PAVE_OK;
    double share = 1.0 / (cvd->params.iterations + 1);
    if (!cvd->labels)
        cvd->labels =
            pv_allocate(j->context, (size_t)cvd->width * (size_t)cvd->height, sizeof *cvd->labels, &result);
    return result ? result : j->backend->labels(j->context, engine, cvd->params.iterations * share, 1, cvd->labels);
}

/* Steps until all are done, or until it pays to go on with less. */
static pave_result run(job *j)
{
    void *engine = NULL;
    pave_cvd *cvd = j->cvd;
    pave_result result = j->backend->open(j->context, j->plane, &engine, cvd->backend_name);
    j->lacking = j->seeds ? pv_most_reach(&cvd->params) - pv_plane_reach(j->plane) : 0;
    j->done = is_done(cvd);
    for (int less = 0; !result && !j->done && !less;) {
        result = step(j, engine);
        j->done = is_done(cvd);
        less = pays(j, rest(j));
    }
    if (!result && j->done)
        result = label(j, engine);
    if (!result)
        result = j->backend->sites(j->context, engine, cvd->sites);
    if (engine)
        j->backend->close(engine);
    cvd->backend = j->backend->id;
    return result;
}

/* A device that fails is no reason to fail, unless the caller named it: the CPU gives the same bytes. */
static pave_result run_anyhow(job *j)
{
    pave_cvd before = *j->cvd, *cvd = j->cvd;
    pave_result result = run(j);
    if ((result != PAVE_ERR_DEVICE && result != PAVE_ERR_UNSUPPORTED) || j->context->backend != PAVE_BACKEND_AUTO)
        return result;
    pv_note(j->context, PAVE_MESSAGE_WARNING, "going on with the CPU: %s", j->context->text);
    cvd->steps = before.steps;
    cvd->movement = before.movement;
    cvd->exact = before.exact;
    cvd->far = before.far;
    cvd->stray = before.stray;
    j->backend = &pv_cpu_backend;
    return run(j);
}

pave_result pv_iterate(pave_context *context, pv_plane *plane, pv_seeds *seeds, uint16_t *edge, pave_cvd *cvd)
{
    const pv_backend *backend = pv_backend_choose(context, plane, cvd->params.iterations);
    job j = { context, backend, plane, seeds, edge, cvd, 0, !seeds, 0 };
    if (!backend)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "this build of libpave has no such backend");
    cvd->movement = cvd->steps = 0;
    cvd->far = cvd->stray = 0;
    cvd->exact = plane->push_within + FIELD_ROUNDING; /* what lies beyond the field cannot be nearer than that */
    pave_result result = PAVE_OK;
    while (!result && !j.done) {
        result = run_anyhow(&j);
        if (!result && !j.done)
            shrink(&j);
    }
    return result;
}
