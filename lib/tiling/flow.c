/* The least cut of a grid, by augmenting paths between two trees that are kept from one path to the next.
 * Source: Boykov and Kolmogorov 2004, "An experimental comparison of min-cut/max-flow algorithms", section 3. */
#include "tiling/flow.h"

#include <string.h>

enum { FREE, SOURCE, SINK };
enum { ROOT = PV_WAYS, NOBODY };
enum { QUEUED_LAST = -1, NOT_QUEUED = -2 };

void pv_flow_free(pv_flow *flow)
{
    pv_release(flow->terminal);
    for (int way = 0; way < PV_WAYS; way++)
        pv_release(flow->capacity[way]);
    pv_release(flow->tree);
    pv_release(flow->parent);
    pv_release(flow->stamp);
    pv_release(flow->distance);
    pv_release(flow->next);
    pv_release(flow->orphan);
    memset(flow, 0, sizeof *flow);
}

pave_result pv_flow_create(pave_context *context, int32_t most_width, int32_t most_height, pv_flow *out)
{
    pave_result result = PAVE_OK;
    size_t nodes = ((size_t)most_width + 2) * ((size_t)most_height + 2);
    memset(out, 0, sizeof *out);
    int32_t **arrays[] = { &out->terminal,    &out->capacity[0], &out->capacity[1], &out->capacity[2],
                           &out->capacity[3], &out->stamp,       &out->distance,    &out->next,
                           &out->orphan };
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays && !result; i++)
        *arrays[i] = pv_allocate(context, nodes, sizeof(int32_t), &result);
    if (!result)
        out->tree = pv_allocate(context, nodes, 1, &result);
    if (!result)
        out->parent = pv_allocate(context, nodes, 1, &result);
    out->most = (int32_t)nodes;
    if (result)
        pv_flow_free(out);
    return result;
}

void pv_flow_begin(pv_flow *flow, int32_t width, int32_t height)
{
    flow->width = width;
    flow->height = height;
    flow->stride = width + 2;
    flow->nodes = flow->stride * (height + 2);
    flow->step[PV_RIGHT] = 1;
    flow->step[PV_DOWN] = flow->stride;
    flow->step[PV_LEFT] = -1;
    flow->step[PV_UP] = -flow->stride;
    size_t n = (size_t)flow->nodes;
    memset(flow->terminal, 0, n * sizeof(int32_t));
    for (int way = 0; way < PV_WAYS; way++)
        memset(flow->capacity[way], 0, n * sizeof(int32_t));
}

static inline int back(int way)
{
    return way ^ 2;
}

/* What can still flow from a node's parent's side to it, over the arc in direction `way`. */
static inline int32_t arc_to_parent(const pv_flow *f, int32_t node, int way, int tree)
{
    return tree == SOURCE ? f->capacity[back(way)][node + f->step[way]] : f->capacity[way][node];
}

static void activate(pv_flow *f, int32_t node)
{
    if (f->next[node] != NOT_QUEUED)
        return;
    f->next[node] = QUEUED_LAST;
    if (f->last >= 0)
        f->next[f->last] = node;
    else
        f->first = node;
    f->last = node;
}

static int32_t next_active(pv_flow *f)
{
    while (f->first >= 0) {
        int32_t node = f->first;
        if (f->tree[node] != FREE)
            return node;
        f->first = f->next[node];
        f->next[node] = NOT_QUEUED;
        if (f->first < 0)
            f->last = -1;
    }
    return -1;
}

static void done_with(pv_flow *f, int32_t node)
{
    f->first = f->next[node];
    f->next[node] = NOT_QUEUED;
    if (f->first < 0)
        f->last = -1;
}

static void plant(pv_flow *f)
{
    size_t n = (size_t)f->nodes;
    memset(f->tree, FREE, n);
    memset(f->parent, NOBODY, n);
    memset(f->stamp, 0, n * sizeof *f->stamp);
    f->first = f->last = -1;
    f->orphans = f->time = 0;
    for (int32_t i = 0; i < f->nodes; i++)
        f->next[i] = NOT_QUEUED;
    for (int32_t i = 0; i < f->nodes; i++) {
        if (!f->terminal[i])
            continue;
        f->tree[i] = f->terminal[i] > 0 ? SOURCE : SINK;
        f->parent[i] = ROOT;
        f->distance[i] = 1;
        activate(f, i);
    }
}

/* Lets the tree of `node` take its free neighbours. Returns the way to a neighbour in the other tree, or NOBODY. */
static int grow(pv_flow *f, int32_t node)
{
    int tree = f->tree[node];
    for (int way = 0; way < PV_WAYS; way++) {
        int32_t other = node + f->step[way];
        int32_t room = tree == SOURCE ? f->capacity[way][node] : f->capacity[back(way)][other];
        if (!room)
            continue;
        if (f->tree[other] == FREE) {
            f->tree[other] = (uint8_t)tree;
            f->parent[other] = (uint8_t)back(way);
            f->stamp[other] = f->stamp[node];
            f->distance[other] = f->distance[node] + 1;
            activate(f, other);
        } else if (f->tree[other] != tree) {
            return way;
        } else if (f->stamp[other] <= f->stamp[node] && f->distance[other] > f->distance[node] + 1) {
            f->parent[other] = (uint8_t)back(way); /* a shorter way to the root */
            f->stamp[other] = f->stamp[node];
            f->distance[other] = f->distance[node] + 1;
        }
    }
    return NOBODY;
}

static int32_t narrowest(const pv_flow *f, int32_t node, int32_t least)
{
    int tree = f->tree[node];
    for (; f->parent[node] != ROOT; node += f->step[f->parent[node]]) {
        int32_t room = arc_to_parent(f, node, f->parent[node], tree);
        least = room < least ? room : least;
    }
    int32_t rest = tree == SOURCE ? f->terminal[node] : -f->terminal[node];
    return rest < least ? rest : least;
}

static void make_orphan(pv_flow *f, int32_t node)
{
    f->parent[node] = NOBODY;
    f->orphan[f->orphans++] = node;
}

static void push(pv_flow *f, int32_t node, int32_t amount)
{
    int tree = f->tree[node];
    while (f->parent[node] != ROOT) {
        int way = f->parent[node];
        int32_t parent = node + f->step[way];
        int32_t *to = tree == SOURCE ? &f->capacity[back(way)][parent] : &f->capacity[way][node];
        int32_t *from = tree == SOURCE ? &f->capacity[way][node] : &f->capacity[back(way)][parent];
        *to -= amount;
        *from += amount;
        if (!*to)
            make_orphan(f, node);
        node = parent;
    }
    f->terminal[node] += tree == SOURCE ? -amount : amount;
    if (!f->terminal[node])
        make_orphan(f, node);
}

static void augment(pv_flow *f, int32_t node, int way)
{
    int32_t other = node + f->step[way];
    int32_t from = f->tree[node] == SOURCE ? node : other, to = from == node ? other : node;
    int forth = from == node ? way : back(way);
    int32_t amount = narrowest(f, to, narrowest(f, from, f->capacity[forth][from]));
    f->capacity[forth][from] -= amount;
    f->capacity[back(forth)][to] += amount;
    push(f, from, amount);
    push(f, to, amount);
}

/* How far a node is from its root, or 0 if it hangs on an orphan. Remembers what it learns. */
static int32_t root_distance(pv_flow *f, int32_t start)
{
    int32_t node = start, walked = 0, distance;
    while (f->stamp[node] != f->time && f->parent[node] < PV_WAYS) {
        node += f->step[f->parent[node]];
        walked++;
    }
    if (f->stamp[node] == f->time)
        distance = walked + f->distance[node];
    else if (f->parent[node] == ROOT)
        distance = walked + 1;
    else
        return 0;
    for (int32_t left = distance, at = start; f->stamp[at] != f->time; at += f->step[f->parent[at]]) {
        f->stamp[at] = f->time;
        f->distance[at] = left--;
        if (f->parent[at] == ROOT)
            break;
    }
    return distance;
}

/* Neighbours of a node that becomes free: those that could take it grow again, its children are orphans too. */
static void let_go(pv_flow *f, int32_t node)
{
    int tree = f->tree[node];
    f->tree[node] = FREE;
    for (int way = 0; way < PV_WAYS; way++) {
        int32_t other = node + f->step[way];
        if (f->tree[other] != tree)
            continue;
        if (arc_to_parent(f, node, way, tree))
            activate(f, other);
        if (f->parent[other] < PV_WAYS && other + f->step[f->parent[other]] == node)
            make_orphan(f, other);
    }
}

static void adopt(pv_flow *f, int32_t node)
{
    int tree = f->tree[node], chosen = NOBODY;
    int32_t least = INT32_MAX;
    for (int way = 0; way < PV_WAYS; way++) {
        int32_t other = node + f->step[way];
        if (f->tree[other] != tree || !arc_to_parent(f, node, way, tree))
            continue;
        int32_t distance = root_distance(f, other);
        if (distance && distance < least) {
            least = distance;
            chosen = way;
        }
    }
    f->parent[node] = (uint8_t)chosen;
    if (chosen == NOBODY) {
        let_go(f, node);
        return;
    }
    f->stamp[node] = f->time;
    f->distance[node] = least + 1;
}

void pv_flow_solve(pv_flow *flow)
{
    plant(flow);
    for (int32_t node; (node = next_active(flow)) >= 0;) {
        int way = grow(flow, node);
        if (way == NOBODY) {
            done_with(flow, node);
            continue;
        }
        flow->time++;
        augment(flow, node, way);
        while (flow->orphans)
            adopt(flow, flow->orphan[--flow->orphans]);
    }
}
