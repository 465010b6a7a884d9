#version 460
// rasterize: what hardware proposes of a triangle is a fragment where the exact edge functions say so.
#extension GL_GOOGLE_include_directive : require
#include "geometry.glsl"
#include "coverage.glsl"

layout(location = 0) perprimitiveEXT flat in uint key;
layout(location = 1) perprimitiveEXT flat in float inverse;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Meshlet m = push.meshlets.at[key >> INDEX_BITS];
    uint diagonal = uint(push.patches.at[m.patch_].diagonal);
    Corners c = corners_of(m, triangle_places(m, diagonal, key & ((1u << INDEX_BITS) - 1)));
    float depth;
    if (covers(c, area_of(c), inverse, pixel, depth)) {
        keep_larger(push.near, pixel, word_of(depth, key));
    }
}
