#version 460
// rasterize: what hardware proposes of an item is a fragment where exact arithmetic says so.
#extension GL_GOOGLE_include_directive : require
#include "outlines.glsl"

layout(location = 0) perprimitiveEXT flat in uint number;
layout(location = 1) perprimitiveEXT flat in uint item;

// Where on the segment, and how deep.
bool stroke(Drawn d, ivec2 pixel, out float depth) {
    Corners c = segment_of(d, item);
    int64_t side;
    float s;
    depth = 0.0;
    if (!meets(c.at[0], c.at[1], radius_of(d, item, c), pixel, side, s)) {
        return false;
    }
    uint leaf = d.m.patch_;
    precise float at = c.depth[0] + (c.depth[1] - c.depth[0]) * s;
    if (KIND == BORDERS) {
        int64_t area = area_of(c);
        // Only the outer side: inside, the triangle's own fragments say it better.
        if (sign_of(side) * sign_of(area) > 0) {
            return false;
        }
        precise float pushed = at - (push.leaves.at[leaf].pen_fold > 0 ? 0.0 : push_of(leaf, c, area));
        at = pushed;
    }
    precise float back = at * PUSH_FACTOR;
    depth = max(back, LEAST_DEPTH);
    return true;
}

bool fragment(Drawn d, ivec2 pixel, out float depth) {
    if (KIND == BORDERS || KIND == FOLDS) {
        return stroke(d, pixel, depth);
    }
    Corners c = triangle_of(d, item);
    int64_t area = area_of(c);
    if (KIND == CONSERVATIVE) {
        bool found = touches(c, area, pixel, depth);
        depth = max(depth, LEAST_DEPTH);
        return found;
    }
    depth = 0.0;
    return area != 0 && covers(c, area, inverse_of(area), pixel, depth);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Drawn d = drawn_of(number);
    float depth;
    if (!fragment(d, pixel, depth)) {
        return;
    }
    ivec2 places[3] = places_of(d, item);
    Corners c = corners_of(d.m, places);
    uint index = KIND == BORDERS ? FIRST_EDGE + item : KIND == FOLDS || KIND == TURNED_AWAY ? FOLD_INDEX : item;
    uint64_t word = word_of(depth, number << INDEX_BITS | index);
    if (KIND == FAR) {
        if (TRIMMED) {
            trim(d.m, places, c, pixel, word);
        } else {
            keep_larger(push.near, pixel, word);
        }
        return;
    }
    // Fill wants nothing that N hides.
    uint64_t near = push.near.at[uint(pixel.y) * push.size[0] + uint(pixel.x)];
    if (depth > depth_of(near)) {
        // A fold has no parameters of its own.
        if (TRIMMED && index != FOLD_INDEX && !keeps_stroke(d.m, places, c, pixel, KIND == BORDERS)) {
            return;
        }
        keep_larger(push.spare, pixel, word);
    }
}
