// Fixed-point arithmetic that is the same on every machine. The GLSL twin of lib/util/fixed.h.
// GLSL leaves / and % of negative numbers open, so that only absolute values are divided.

int64_t divide_rounded(int64_t a, int64_t b)
{
    int64_t q = int64_t((uint64_t(b / 2) + uint64_t(abs(a))) / uint64_t(b));
    return a < 0 ? -q : q;
}

// Digit by digit: no multiplication.
uint64_t isqrt(uint64_t v)
{
    uint64_t root = 0;
    for (uint64_t bit = uint64_t(1) << 62; bit != 0; bit >>= 2) {
        bool fits = v >= root + bit;
        v -= fits ? root + bit : 0;
        root = (root >> 1) + (fits ? bit : 0);
    }
    return root;
}

// (a * b) >> 30 of numbers below 2^31.
uint multiply30(uint a, uint b)
{
    uint high, low;
    umulExtended(a, b, high, low);
    return high << 2 | low >> 30;
}

// Sine of a quarter turn times t / 16384, in 1/65536.
int quarter_sine(int t)
{
    uint x = uint(t) << 16, x2 = multiply30(x, x);
    uint p = 85291978 - multiply30(x2, 4652626);
    p = 693522166 - multiply30(x2, p);
    p = 1686624005 - multiply30(x2, p);
    return int((multiply30(x, p) + 8192) >> 14);
}

// Cosine and sine, in 1/65536, of an angle of which 65536 make a turn.
ivec2 turned(int angle)
{
    int t = angle & 16383, quarter = (angle >> 14) & 3;
    int s = quarter_sine(t), c = quarter_sine(16384 - t);
    return quarter == 0 ? ivec2(c, s) : quarter == 1 ? ivec2(-s, c) : quarter == 2 ? ivec2(-c, -s) : ivec2(s, -c);
}
