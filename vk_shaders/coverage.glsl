// The pixel centres that a triangle covers, and its depth there: exactly as in kernels/triangle.cuh and
// src/stages/rasterize.rs.
#include "numbers.glsl"

// Sub-pixels along both axes up to which edge functions about the first corner fit 32 bits: 64 pixels.
const int SMALL = 64 * SUBPIXELS;

// Turned so that the area is positive.
Corners turned(Corners c, int64_t area) {
    return area < 0 ? Corners(ivec2[3](c.at[0], c.at[2], c.at[1]), float[3](c.depth[0], c.depth[2], c.depth[1])) : c;
}

// Points on edge k belong to this triangle: the top-left rule, y down.
bool owns(Corners c, int k) {
    ivec2 way = c.at[(k + 1) % 3] - c.at[k];
    return way.y < 0 || (way.y == 0 && way.x > 0);
}

// Edge function of corner k to the next at a point: positive inside.
int64_t edge_at(Corners c, int k, i64vec2 point) {
    i64vec2 way = i64vec2(c.at[(k + 1) % 3]) - i64vec2(c.at[k]), to = point - i64vec2(c.at[k]);
    return way.x * to.y - way.y * to.x;
}

int edge_near(Corners c, int k, ivec2 point) {
    ivec2 way = c.at[(k + 1) % 3] - c.at[k], to = point - c.at[k];
    return way.x * to.y - way.y * to.x;
}

// One over its area, rounded to nearest.
float inverse_of(int64_t area) { return quotient(1.0, float(abs(area))); }

// True where the triangle covers a pixel's centre; `depth` there. `area` is not zero, `inverse` is one over it.
bool covers(Corners given, int64_t area, float inverse, ivec2 pixel, out float depth) {
    Corners c = turned(given, area);
    ivec2 extent = max(max(c.at[0], c.at[1]), c.at[2]) - min(min(c.at[0], c.at[1]), c.at[2]);
    bool small = max(extent.x, extent.y) < SMALL;
    vec3 weight;
    bool inside = true;
    // A pixel outside the box is never asked for where all is small: hardware proposes none.
    ivec2 center = pixel * SUBPIXELS + int(HALF_SUBPIXELS);
    [[unroll]] for (int k = 0; k < 3; k++) {
        int bias = owns(c, k) ? 0 : 1;
        if (small) {
            int e = edge_near(c, k, center);
            inside = inside && e >= bias;
            weight[k] = float(e);
        } else {
            int64_t e = edge_at(c, k, i64vec2(center));
            inside = inside && e >= bias;
            weight[k] = float(e);
        }
    }
    precise float d = weight[0] * (c.depth[2] * inverse) + weight[1] * (c.depth[0] * inverse) + weight[2] * (c.depth[1] * inverse);
    depth = d;
    return inside;
}
