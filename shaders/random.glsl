// Counter-based random numbers: Philox 4x32, 10 rounds. The GLSL twin of lib/util/random.h.

const uint DRAW_REVIVE = 4;

uvec4 philox(uvec4 w, uvec2 key)
{
    for (int i = 0; i < 10; i++) {
        uvec2 high, low;
        umulExtended(w.xz, uvec2(0xD2511F53u, 0xCD9E8D57u), high, low);
        w = uvec4(high.y ^ w.y ^ key.x, low.y, high.x ^ w.w ^ key.y, low.x);
        key += uvec2(0x9E3779B9u, 0xBB67AE85u);
    }
    return w;
}

// A word as a number of 0 .. range-1.
uint below(uint word, uint range)
{
    uint high, low;
    umulExtended(word, range, high, low);
    return high;
}
