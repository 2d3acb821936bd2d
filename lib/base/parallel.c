/* A pool of threads that sleeps between runs. The calling thread works too, and alone makes the callbacks. */
#include "base/parallel.h"

#include <pthread.h>
#include <signal.h>

struct pv_pool {
    pthread_mutex_t lock;
    pthread_cond_t wake, rest;
    int32_t threads;   /* besides the calling one */
    int32_t ready;     /* number given to the next thread that starts */
    int32_t running;   /* threads not yet done with the run under way */
    uint32_t run;      /* counts runs */
    int32_t leave;
    pv_task *task;
    void *data;
    int32_t tasks;
    atomic_int next, finished, stop;
    pthread_t thread[];
};

static void work(pv_pool *pool, int32_t worker)
{
    int32_t i;
    while (!atomic_load(&pool->stop) && (i = atomic_fetch_add(&pool->next, 1)) < pool->tasks) {
        pool->task(pool->data, i, worker);
        atomic_fetch_add(&pool->finished, 1);
    }
}

static void *thread_main(void *argument)
{
    pv_pool *pool = argument;
    pthread_mutex_lock(&pool->lock);
    int32_t worker = ++pool->ready;
    for (uint32_t seen = 0;;) {
        while (pool->run == seen && !pool->leave)
            pthread_cond_wait(&pool->wake, &pool->lock);
        if (pool->leave)
            break;
        seen = pool->run;
        pthread_mutex_unlock(&pool->lock);
        work(pool, worker);
        pthread_mutex_lock(&pool->lock);
        if (--pool->running == 0)
            pthread_cond_signal(&pool->rest);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Signals stay with the host's own threads. */
static void start_threads(pv_pool *pool, int32_t wanted)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (pool->threads < wanted && !pthread_create(&pool->thread[pool->threads], NULL, thread_main, pool))
        pool->threads++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

static pv_pool *make_pool(pave_context *context)
{
    pave_result result;
    int32_t wanted = context->threads - 1;
    pv_pool *pool = pv_allocate_zeroed(context, 1, sizeof *pool + (size_t)wanted * sizeof(pthread_t), &result);
    if (!pool)
        return NULL;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->rest, NULL);
    start_threads(pool, wanted);
    return pool;
}

void pv_pool_free(pv_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->leave = 1;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    for (int32_t i = 0; i < pool->threads; i++)
        pthread_join(pool->thread[i], NULL);
    pthread_cond_destroy(&pool->rest);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->lock);
    pv_release(pool);
}

int32_t pv_workers(const pave_context *context)
{
    return context->threads;
}

static pave_result run_alone(pave_context *context, int32_t tasks, pv_task *task, void *data, double from, double to)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < tasks && !result; i++) {
        task(data, i, 0);
        result = pv_progress(context, from + (to - from) * (i + 1) / tasks);
    }
    return result;
}

static void begin_run(pv_pool *pool, int32_t tasks, pv_task *task, void *data)
{
    pool->task = task;
    pool->data = data;
    pool->tasks = tasks;
    atomic_store(&pool->next, 0);
    atomic_store(&pool->finished, 0);
    atomic_store(&pool->stop, 0);
    pthread_mutex_lock(&pool->lock);
    pool->running = pool->threads;
    pool->run++;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
}

static void wait_for_run(pv_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    while (pool->running)
        pthread_cond_wait(&pool->rest, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}

pave_result pv_parallel(pave_context *context, int32_t tasks, pv_task *task, void *data, double from, double to)
{
    if (context->threads > 1 && tasks > 1 && !context->pool)
        context->pool = make_pool(context);
    pv_pool *pool = context->pool;
    if (!pool || tasks <= 1)
        return run_alone(context, tasks, task, data, from, to);

    pave_result result = PAVE_OK;
    begin_run(pool, tasks, task, data);
    int32_t i;
    while (!result && (i = atomic_fetch_add(&pool->next, 1)) < tasks) {
        task(data, i, 0);
        int32_t finished = atomic_fetch_add(&pool->finished, 1) + 1;
        result = pv_progress(context, from + (to - from) * finished / tasks);
    }
    if (result)
        atomic_store(&pool->stop, 1);
    wait_for_run(pool);
    return result ? result : pv_progress(context, to);
}

typedef struct runs {
    pv_run_task *task;
    void *data;
    int32_t count, run;
} runs;

static void run_task(void *data, int32_t index, int32_t worker)
{
    const runs *r = data;
    int32_t begin = index * r->run, left = r->count - begin;
    r->task(r->data, begin, begin + (left < r->run ? left : r->run), worker);
}

pave_result pv_parallel_runs(pave_context *context, int32_t count, int32_t run, pv_run_task *task, void *data,
                             double from, double to)
{
    runs all = { task, data, count, run };
    return pv_parallel(context, count ? (count - 1) / run + 1 : 0, run_task, &all, from, to);
}
