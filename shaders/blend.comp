// Weighted sums of a factored BTF's samples, a workgroup for each pixel: the GLSL twin of pv_btf_sample in
// lib/btf/samples.c and of pv_colour_decode in lib/btf/colour.c.
#version 450

const int LANES = 64;
layout(local_size_x = LANES) in;

layout(push_constant, std430) uniform Push {
    int base, most, channels, joint, colour;
    int components[3], left[3], right[3];
    float space[12];
} push;

struct Term {
    int texel, pair;
    float weight[3];
};

layout(binding = 0, std430) readonly buffer Terms { Term term[]; } terms;
layout(binding = 1, std430) readonly buffer Counts { int count[]; } counts;
layout(binding = 2, std430) readonly buffer Left { float at[]; } left;
layout(binding = 3, std430) readonly buffer Right { float at[]; } right;
layout(binding = 4, std430) writeonly buffer Sums { float at[]; } sums;

shared vec3 part[LANES];

const float LEAST = 1e-5;
// PV_COLOUR_ of lib/btf/btf.h
const int YUV = 1, PCA = 3, YCOCG = 4, LOG_Y_UV = 9, LOGS_YUV = 10, LOG_YUV = 11, LOG = 12;

float product(int channel, Term term)
{
    int n = push.components[channel];
    int row = push.joint != 0 ? term.pair * push.channels + channel : term.pair;
    int a = push.left[channel] + row * n, b = push.right[channel] + term.texel * n;
    float sum = 0;
    for (int i = 0; i < n; i++)
        sum += left.at[a + i] * right.at[b + i];
    return sum;
}

vec3 from_yuv(float y, float u, float v)
{
    return vec3(y + 1.13983 * v, y - 0.39465 * u - 0.5806 * v, y + 2.03211 * u);
}

vec3 from_space(vec3 v)
{
    vec3 sum;
    for (int c = 0; c < 3; c++)
        sum[c] = push.space[c] + v.x * push.space[3 + c] + v.y * push.space[6 + c] + v.z * push.space[9 + c];
    return sum;
}

vec3 decode(vec3 v)
{
    float whole = push.colour >= LOG_Y_UV ? exp(v.x) : 0.0, y = whole - LEAST;
    switch (push.colour) {
    case YUV: return from_yuv(v.x, v.y, v.z);
    case PCA: return from_space(v);
    case YCOCG: return vec3(v.x + v.y - v.z, v.x + v.z, v.x - v.y - v.z);
    case LOG_Y_UV: return from_yuv(y, v.y, v.z);
    case LOGS_YUV: return from_yuv(y, exp(v.y) - LEAST, exp(v.z) - LEAST);
    case LOG_YUV: return from_yuv(y, v.y * whole, v.z * whole);
    case LOG: return exp(v) - LEAST;
    default: return v;
    }
}

void main()
{
    int pixel = push.base + int(gl_WorkGroupID.x), lane = int(gl_LocalInvocationID.x);
    vec3 sum = vec3(0);
    for (int i = lane; i < counts.count[pixel]; i += LANES) {
        Term term = terms.term[pixel * push.most + i];
        vec3 value = vec3(0);
        for (int c = 0; c < push.channels; c++)
            value[c] = product(c, term);
        sum += vec3(term.weight[0], term.weight[1], term.weight[2]) * decode(value);
    }
    part[lane] = sum;
    for (int half_of = LANES / 2; half_of > 0; half_of /= 2) {
        barrier();
        if (lane < half_of)
            part[lane] += part[lane + half_of];
    }
    if (lane == 0)
        for (int c = 0; c < 3; c++)
            sums.at[3 * pixel + c] = part[0][c];
}
