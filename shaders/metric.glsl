// The distance that decides to which site a pixel belongs. The GLSL twin of lib/backend/metric.h.

const int TILE = 8;
const float TILE_RADIUS = 1268.0; // tile centre to the farthest pixel centre: 3.5*sqrt(2) px, rounded up

uint64_t metric(const Site s, int x, int y)
{
    int64_t dx = int64_t(x) - s.place.x, dy = int64_t(y) - s.place.y;
    int64_t u = (dx * s.place.z + dy * s.place.w + 32768) >> 16;
    int64_t v = (dy * s.place.z - dx * s.place.w + 32768) >> 16;
    u = max(abs(u) - s.shape.x, int64_t(0));
    v = max(abs(v) - s.shape.y, int64_t(0));
    return uint64_t(u * u) + uint64_t(v * v);
}

// The true distance, but for 2^-20 of the way: for bounds only.
float metric_about(const Site s, ivec2 p)
{
    vec2 d = vec2(p - s.place.xy), turn = vec2(s.place.zw) / 65536.0;
    vec2 w = vec2(d.x * turn.x + d.y * turn.y, d.y * turn.x - d.x * turn.y);
    return length(max(abs(w) - vec2(s.shape.xy), 0.0));
}
