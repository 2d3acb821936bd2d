// Walking over the buckets. The includer has `bool visit(uint i, ivec2 p)`, which is shown the sites of a box of
// buckets by their place in `sorted` and answers whether to go on.
//
// Drivers on processors stop a shader's loops after 65535 rounds of all its lanes, whatever is left to do; so the
// search gives up before, where sites lie too thick or too far apart, and says so in `lost`.

int rounds = 0;
bool lost = false;

bool visit(uint i, ivec2 p);

struct Box {
    ivec2 low, high;
};

Box box_around(ivec2 low, ivec2 high)
{
    return Box(max(low, ivec2(0)), min(high, ivec2(plane.across, plane.down) - 1));
}

// The buckets within `radius` of p, and a little more.
Box box_within(ivec2 p, float radius)
{
    vec2 r = vec2(radius * 1.001 + 256.0);
    return box_around(ivec2(floor((vec2(p) - r) / plane.cell)), ivec2(floor((vec2(p) + r) / plane.cell)));
}

void search_box(Box box, ivec2 p)
{
    for (int row = box.low.y; row <= box.high.y && !lost; row++) {
        int head = row * (plane.across + 1);
        uint i = first[head + box.low.x], end = first[head + box.high.x + 1];
        rounds += int(end - i) + 1;
        lost = rounds > plane.patience;
        for (; i < end && !lost; i++)
            if (!visit(i, p))
                return;
    }
}

// Squares of buckets around p, ever larger.
Box square(ivec2 p, int ring)
{
    ivec2 b = min(bucket_of(p.x, p.y), ivec2(plane.across, plane.down) - 1);
    return box_around(b - ring, b + ring);
}
