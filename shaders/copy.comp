// Moves the copies of sites to where their originals are. The GLSL twin of pv_site_copy in lib/backend/relax.c.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"

layout(local_size_x = 64) in;

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    if (at >= plane.count)
        return;
    int i = plane.base + at, original = home[i].w - 1;
    if (original < 0)
        return;
    ivec2 p = ivec2(site[6 * original], site[6 * original + 1]) + home[i].xy;
    p = clamp(p, ivec2(0), 256 * ivec2(plane.width, plane.height) - 1);
    site[6 * i] = p.x;
    site[6 * i + 1] = p.y;
    site[6 * i + 2] = site[6 * original + 2];
    site[6 * i + 3] = site[6 * original + 3];
}
