// Gradient noise in the plane, in integers. The GLSL twin of lib/util/noise.h.

uint lattice_hash(uint key, int x, int y)
{
    uint h = key ^ uint(x) * 0x9E3779B1u;
    h = (h ^ h >> 15) * 0x85EBCA6Bu;
    h ^= uint(y) * 0xC2B2AE35u;
    h = (h ^ h >> 13) * 0x27D4EB2Fu;
    h = (h ^ h >> 16) * 0x165667B1u;
    return h ^ h >> 15;
}

int64_t noise_corner(uint key, int x, int y, int64_t fx, int64_t fy)
{
    ivec2 t = turned(int(lattice_hash(key, x, y) >> 16));
    return (t.x * fx + t.y * fy) >> 16;
}

int64_t fade(int64_t t)
{
    int64_t poly = (t * (6 * t - 15 * 65536) >> 16) + 10 * 65536;
    return ((t * t >> 16) * t >> 16) * poly >> 16;
}

int noise_next(Lattice l, int i)
{
    return l.repeats && i + 1 == l.cells ? 0 : i + 1;
}

// How far into its cell a place is, in 1/65536 of the cell.
int64_t noise_way(Lattice l, int place, int cell)
{
    return int64_t((uint64_t(int64_t(place) * l.cells - int64_t(cell) * l.span) << 16) / uint64_t(l.span));
}

// Noise at (x, y), -1 .. 1 in 1/65536; the lattices' cells are its waves.
int64_t noise(uint key, Lattice across, Lattice down, int x, int y)
{
    x = lattice_place(across, x);
    y = lattice_place(down, y);
    int ix = lattice_cell(across, x), iy = lattice_cell(down, y);
    int jx = noise_next(across, ix), jy = noise_next(down, iy);
    int64_t fx = noise_way(across, x, ix), fy = noise_way(down, y, iy);
    int64_t a = noise_corner(key, ix, iy, fx, fy), b = noise_corner(key, jx, iy, fx - 65536, fy);
    int64_t c = noise_corner(key, ix, jy, fx, fy - 65536);
    int64_t d = noise_corner(key, jx, jy, fx - 65536, fy - 65536);
    int64_t u = fade(fx), v = fade(fy);
    a += (b - a) * u >> 16;
    c += (d - c) * u >> 16;
    return (a + ((c - a) * v >> 16)) * 92682 >> 16;
}
