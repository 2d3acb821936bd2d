// The distance that decides to which site a pixel belongs. The GLSL twin of lib/backend/metric.h.

const int TILE = 8;
const float TILE_RADIUS = 1268.0; // tile centre to the farthest pixel centre: 3.5*sqrt(2) px, rounded up

layout(constant_id = 1) const int METRIC = 0; // PAVE_METRIC_: box, square, diamond

uint64_t metric(const Site s, int x, int y)
{
    int64_t dx = int64_t(x) - s.place.x, dy = int64_t(y) - s.place.y;
    int64_t u = (dx * s.place.z + dy * s.place.w + 32768) >> 16;
    int64_t v = (dy * s.place.z - dx * s.place.w + 32768) >> 16;
    u = abs(u);
    v = abs(v);
    if (METRIC == 0) {
        u = max(u - s.shape.x, int64_t(0));
        v = max(v - s.shape.y, int64_t(0));
        return uint64_t(u * u) + uint64_t(v * v);
    }
    u = u * s.shape.x >> 16;
    v = v * s.shape.y >> 16;
    u = METRIC == 2 ? u + v : max(u, v);
    return uint64_t(u * u);
}

// The same in 32 bits, for points within 127 px of the site.
uint metric_narrow(const Site s, ivec2 p)
{
    ivec2 d = p - s.place.xy;
    int u = (d.x * s.place.z + d.y * s.place.w + 32768) >> 16, v = (d.y * s.place.z - d.x * s.place.w + 32768) >> 16;
    uvec2 w = uvec2(abs(ivec2(u, v))), shape = uvec2(s.shape.xy);
    if (METRIC == 0) {
        w -= min(w, shape);
        return w.x * w.x + w.y * w.y;
    }
    w = w * shape >> 16;
    uint z = METRIC == 2 ? w.x + w.y : max(w.x, w.y);
    return z * z;
}

// A squared distance is kept as a depth, from NEAREST on; 1, the farthest depth, is beyond FARTHEST.
const uint NEAREST = 0x00800000u, FARTHEST = 0x3effffffu;

// The true distance, but for 2^-20 of the way: for bounds only.
float metric_about(const Site s, ivec2 p)
{
    vec2 d = vec2(p - s.place.xy), turn = vec2(s.place.zw) / 65536.0;
    vec2 w = vec2(d.x * turn.x + d.y * turn.y, d.y * turn.x - d.x * turn.y);
    if (METRIC == 0)
        return length(max(abs(w) - vec2(s.shape.xy), 0.0));
    w = abs(w) * vec2(s.shape.xy) / 65536.0;
    return METRIC == 2 ? w.x + w.y : max(w.x, w.y);
}

// How far from a site a point at this distance may lie.
float range(float d)
{
    return d * STRETCH + plane.reach;
}
