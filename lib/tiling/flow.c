/* The least cut of a grid, by augmenting paths between two trees that are kept from one path to the next.
 * Source: Boykov and Kolmogorov 2004, "An experimental comparison of min-cut/max-flow algorithms", section 3. */
#include "tiling/flow.h"

#include <string.h>

enum { FREE, SOURCE, SINK };
enum { ROOT = PV_WAYS, NOBODY };
enum { QUEUED_LAST = -1, NOT_QUEUED = -2 };

void pv_flow_free(pv_flow *flow)
{
    pv_release(flow->node);
    pv_release(flow->orphan);
    memset(flow, 0, sizeof *flow);
}

pave_result pv_flow_create(pave_context *context, int32_t most_width, int32_t most_height, pv_flow *out)
{
    pave_result result = PAVE_OK;
    size_t nodes = ((size_t)most_width + 2) * ((size_t)most_height + 2);
    memset(out, 0, sizeof *out);
    if (nodes > PV_MOST_NODES)
        return pv_fail(context, PAVE_ERR_INTERNAL, "a cut of %zu nodes", nodes);
    out->node = pv_allocate(context, nodes, sizeof *out->node, &result);
    if (!result)
        out->orphan = pv_allocate(context, nodes, sizeof *out->orphan, &result);
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
    memset(flow->node, 0, (size_t)flow->nodes * sizeof *flow->node);
}

static inline int back(int way)
{
    return way ^ 2;
}

/* What can still flow from a node's parent's side to it, over the arc in direction `way`. */
static inline int32_t arc_to_parent(const pv_flow *f, int32_t node, int way, int tree)
{
    return tree == SOURCE ? f->node[node + f->step[way]].capacity[back(way)] : f->node[node].capacity[way];
}

static void activate(pv_flow *f, int32_t node)
{
    if (f->node[node].next != NOT_QUEUED)
        return;
    f->node[node].next = QUEUED_LAST;
    if (f->last >= 0)
        f->node[f->last].next = node;
    else
        f->first = node;
    f->last = node;
}

static int32_t next_active(pv_flow *f)
{
    while (f->first >= 0) {
        int32_t node = f->first;
        if (f->node[node].tree != FREE)
            return node;
        f->first = f->node[node].next;
        f->node[node].next = NOT_QUEUED;
        if (f->first < 0)
            f->last = -1;
    }
    return -1;
}

static void done_with(pv_flow *f, int32_t node)
{
    f->first = f->node[node].next;
    f->node[node].next = NOT_QUEUED;
    if (f->first < 0)
        f->last = -1;
}

static void plant(pv_flow *f)
{
    f->first = f->last = -1;
    f->orphan_from = f->orphan_to = f->time = 0;
    for (int32_t i = 0; i < f->nodes; i++) {
        pv_node *node = &f->node[i];
        node->tree = node->terminal > 0 ? SOURCE : node->terminal < 0 ? SINK : FREE;
        node->parent = node->tree == FREE ? NOBODY : ROOT;
        node->next = NOT_QUEUED;
        node->stamp = 0;
        node->distance = 1;
    }
    for (int32_t i = 0; i < f->nodes; i++)
        if (f->node[i].tree != FREE)
            activate(f, i);
}

/* Lets the tree of `node` take its free neighbours. Returns the way to a neighbour in the other tree, or NOBODY. */
static int grow(pv_flow *f, int32_t node)
{
    int tree = f->node[node].tree;
    for (int way = 0; way < PV_WAYS; way++) {
        int32_t other = node + f->step[way];
        int32_t room = tree == SOURCE ? f->node[node].capacity[way] : f->node[other].capacity[back(way)];
        if (!room)
            continue;
        if (f->node[other].tree == FREE) {
            f->node[other].tree = (uint8_t)tree;
            f->node[other].parent = (uint8_t)back(way);
            f->node[other].stamp = f->node[node].stamp;
            f->node[other].distance = f->node[node].distance + 1;
            activate(f, other);
        } else if (f->node[other].tree != tree) {
            return way;
        } else if (f->node[other].stamp <= f->node[node].stamp &&
                   f->node[other].distance > f->node[node].distance + 1) {
            f->node[other].parent = (uint8_t)back(way); /* a shorter way to the root */
            f->node[other].stamp = f->node[node].stamp;
            f->node[other].distance = f->node[node].distance + 1;
        }
    }
    return NOBODY;
}

static int32_t narrowest(const pv_flow *f, int32_t node, int32_t least)
{
    int tree = f->node[node].tree;
    for (; f->node[node].parent != ROOT; node += f->step[f->node[node].parent]) {
        int32_t room = arc_to_parent(f, node, f->node[node].parent, tree);
        least = room < least ? room : least;
    }
    int32_t rest = tree == SOURCE ? f->node[node].terminal : -f->node[node].terminal;
    return rest < least ? rest : least;
}

static void make_orphan(pv_flow *f, int32_t node)
{
    f->node[node].parent = NOBODY;
    f->orphan[f->orphan_to++] = node;
    f->orphan_to = f->orphan_to < f->nodes ? f->orphan_to : 0;
}

static void push(pv_flow *f, int32_t node, int32_t amount)
{
    int tree = f->node[node].tree;
    while (f->node[node].parent != ROOT) {
        int way = f->node[node].parent;
        int32_t parent = node + f->step[way];
        int32_t *to = tree == SOURCE ? &f->node[parent].capacity[back(way)] : &f->node[node].capacity[way];
        int32_t *from = tree == SOURCE ? &f->node[node].capacity[way] : &f->node[parent].capacity[back(way)];
        *to -= amount;
        *from += amount;
        if (!*to)
            make_orphan(f, node);
        node = parent;
    }
    f->node[node].terminal += tree == SOURCE ? -amount : amount;
    if (!f->node[node].terminal)
        make_orphan(f, node);
}

static void augment(pv_flow *f, int32_t node, int way)
{
    int32_t other = node + f->step[way];
    int32_t from = f->node[node].tree == SOURCE ? node : other, to = from == node ? other : node;
    int forth = from == node ? way : back(way);
    int32_t amount = narrowest(f, to, narrowest(f, from, f->node[from].capacity[forth]));
    f->node[from].capacity[forth] -= amount;
    f->node[to].capacity[back(forth)] += amount;
    push(f, from, amount);
    push(f, to, amount);
}

/* How far a node is from its root, or 0 if it hangs on an orphan. Remembers what it learns. */
static int32_t root_distance(pv_flow *f, int32_t start)
{
    int32_t node = start, walked = 0, distance;
    while (f->node[node].stamp != f->time && f->node[node].parent < PV_WAYS) {
        node += f->step[f->node[node].parent];
        walked++;
    }
    if (f->node[node].stamp == f->time)
        distance = walked + f->node[node].distance;
    else if (f->node[node].parent == ROOT)
        distance = walked + 1;
    else
        return 0;
    for (int32_t left = distance, at = start; f->node[at].stamp != f->time; at += f->step[f->node[at].parent]) {
        f->node[at].stamp = f->time;
        f->node[at].distance = left--;
        if (f->node[at].parent == ROOT)
            break;
    }
    return distance;
}

/* Neighbours of a node that becomes free: those that could take it grow again, its children are orphans too. */
static void let_go(pv_flow *f, int32_t node)
{
    int tree = f->node[node].tree;
    f->node[node].tree = FREE;
    for (int way = 0; way < PV_WAYS; way++) {
        int32_t other = node + f->step[way];
        if (f->node[other].tree != tree)
            continue;
        if (arc_to_parent(f, node, way, tree))
            activate(f, other);
        if (f->node[other].parent < PV_WAYS && other + f->step[f->node[other].parent] == node)
            make_orphan(f, other);
    }
}

static void adopt(pv_flow *f, int32_t node)
{
    int tree = f->node[node].tree, chosen = NOBODY;
    int32_t least = INT32_MAX;
    for (int way = 0; way < PV_WAYS; way++) {
        int32_t other = node + f->step[way];
        if (f->node[other].tree != tree || !arc_to_parent(f, node, way, tree))
            continue;
        int32_t distance = root_distance(f, other);
        if (distance && distance < least) {
            least = distance;
            chosen = way;
        }
    }
    f->node[node].parent = (uint8_t)chosen;
    if (chosen == NOBODY) {
        let_go(f, node);
        return;
    }
    f->node[node].stamp = f->time;
    f->node[node].distance = least + 1;
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
        while (flow->orphan_from != flow->orphan_to) {
            int32_t orphan = flow->orphan[flow->orphan_from++];
            flow->orphan_from = flow->orphan_from < flow->nodes ? flow->orphan_from : 0;
            adopt(flow, orphan);
        }
    }
}
