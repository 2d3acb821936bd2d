/* The cracks between pieces: junctions where three or more meet, and chains of cracks between junctions. */
#pragma once

#include "stones/pieces.h"

/* Ways out of a junction, counter-clockwise as seen: 0 east, 1 north-east, 2 north ... 7 south-east. */
enum { PV_WAYS = 8 };

typedef struct pv_chain {
    int32_t from, to;    /* junctions */
    int32_t out, in;     /* ways: leaving `from`, and back from `to` */
    int32_t left, right; /* pieces, -1: outside */
    int32_t length;      /* cracks; 0 between the halves of a pinch */
} pv_chain;

typedef struct pv_net {
    const pv_pieces *pieces;
    int32_t junction_count, chain_count;
    int64_t *row;    /* where the junctions of each lattice row begin */
    int32_t *x, *y;  /* lattice points: the corner of pixel (x, y) */
    int8_t *pinch;   /* where a piece touches itself across a corner there are two: the way into the piece; else -1 */
    int32_t *exits;  /* PV_WAYS a junction: half chain 2c leaves the start of chain c, 2c+1 its end; -1: no way */
    pv_chain *chain;
} pv_net;

pave_result pv_net_trace(pave_context *context, const pv_pieces *pieces, pv_net *out);
void pv_net_free(pv_net *net);

/* The lattice points of a chain, length + 1 pairs. */
void pv_net_path(const pv_net *net, const pv_chain *chain, int32_t *xy);

/* The half chain that follows in the ring of the piece on the left. */
int32_t pv_net_next(const pv_net *net, int32_t half);

static inline int32_t pv_net_left(const pv_net *net, int32_t half)
{
    const pv_chain *c = &net->chain[half >> 1];
    return half & 1 ? c->right : c->left;
}
