#version 460
// rasterize: what hardware proposes of a triangle is a fragment where the exact edge functions say so.
#extension GL_GOOGLE_include_directive : require
#include "geometry.glsl"
#include "trim.glsl"

layout(location = 0) perprimitiveEXT flat in uint key;
layout(location = 1) perprimitiveEXT flat in float inverse;
layout(location = 2) perprimitiveEXT flat in uint region;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Meshlet m = push.meshlets.at[key >> INDEX_BITS];
    uint diagonal = uint(push.patches.at[m.patch_].diagonal);
    ivec2 places[3] = triangle_places(m, diagonal, key & ((1u << INDEX_BITS) - 1));
    Corners c = corners_of(m, places);
    float depth;
    if (!covers(c, area_of(c), inverse, pixel, depth)) {
        return;
    }
    if (TRIMMED && region == REGION_BOUNDARY) {
        trim(m, places, c, pixel, word_of(depth, key));
    } else {
        keep_larger(push.near, pixel, word_of(depth, key));
    }
}
