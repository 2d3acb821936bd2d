// Cells along a line, in integers. The GLSL twin of lib/util/lattice.h.

struct Lattice {
    int span, cells;
    bool repeats;
};

Lattice lattice_of(int cell, int period)
{
    return period == 0 ? Lattice(cell, 1, false) : Lattice(period, max(1, (2 * period + cell) / (2 * cell)), true);
}

// A place as one of the first period; those of a lattice that does not repeat are not negative.
int lattice_place(Lattice l, int at)
{
    return !l.repeats ? at : at < 0 ? l.span - 1 - (-1 - at) % l.span : at % l.span;
}

int lattice_cell(Lattice l, int place)
{
    return l.repeats ? int(uint64_t(int64_t(place) * l.cells) / uint64_t(l.span)) : place / l.span;
}

// The first place of a cell.
int lattice_start(Lattice l, int cell)
{
    return int(uint64_t(int64_t(cell) * l.span + l.cells - 1) / uint64_t(l.cells));
}
