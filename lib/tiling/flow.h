/* The least cut of a grid of pixels. */
#pragma once

#include "base/context.h"

enum { PV_RIGHT = 0, PV_DOWN = 1, PV_LEFT = 2, PV_UP = 3, PV_WAYS = 4 };

/* A node: 32 bytes, for neighbours are looked at together. */
typedef struct pv_node {
    int32_t capacity[PV_WAYS]; /* what the arc to each neighbour can still carry */
    int32_t terminal;          /* above 0: what the source can still send here; below: what the sink still takes */
    int32_t stamp;             /* when its distance to its root was known */
    int32_t next;              /* in the queue of active nodes */
    uint16_t distance;
    uint8_t tree, parent;      /* whose tree it is in, and the way to its parent there */
} pv_node;

/* A grid of nodes with a frame of one node around it, so that every node of the grid has four neighbours. Capacities
 * are integers, so the least cut is exact; where several are least it is the one with the fewest nodes on the
 * source's side, which is unique. */
typedef struct pv_flow {
    int32_t width, height, stride, nodes;
    int32_t step[PV_WAYS];
    pv_node *node;
    int32_t *orphan;
    int32_t first, last, time;
    int32_t orphan_from, orphan_to; /* the orphans, first come first served, around the end of the array */
} pv_flow;

enum { PV_MOST_NODES = 60000 };

/* Room for at most PV_MOST_NODES, the frame included. */
pave_result pv_flow_create(pave_context *context, int32_t most_width, int32_t most_height, pv_flow *out);
void pv_flow_free(pv_flow *flow);

/* Begins a grid with no arcs. */
void pv_flow_begin(pv_flow *flow, int32_t width, int32_t height);

static inline int32_t pv_flow_node(const pv_flow *flow, int32_t x, int32_t y)
{
    return (y + 1) * flow->stride + x + 1;
}

/* Finds the cut. Afterwards pv_flow_chosen tells whether a node is on the source's side. */
void pv_flow_solve(pv_flow *flow);

static inline int pv_flow_chosen(const pv_flow *flow, int32_t node)
{
    return flow->node[node].tree == 1;
}
