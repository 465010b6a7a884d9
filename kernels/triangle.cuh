// A triangle on the screen in sub-pixels: edge functions, the top-left rule, coverage. Twin of src/stages/rasterize.rs.
#pragma once
#include "topology.cuh"

using i64 = long long;

constexpr i64 HALF_SUBPIXELS = SUBPIXELS / 2;
constexpr int SUBPIXEL_BITS = 8;
static_assert(1 << SUBPIXEL_BITS == SUBPIXELS);

// First and last.
struct Range {
    i64 low, high;

    __device__ bool empty() const { return low > high; }
};

struct PixelBox {
    Range x, y;

    __device__ bool empty() const { return x.empty() || y.empty(); }
    __device__ i64 pixels() const { return (x.high - x.low + 1) * (y.high - y.low + 1); }
};

// Sub-pixel position of a pixel's centre.
static __device__ __forceinline__ i64 center_of(i64 pixel) { return pixel * SUBPIXELS + HALF_SUBPIXELS; }

// Pixels whose centres lie within [low, high] sub-pixels.
static __device__ __forceinline__ Range pixel_range(i64 low, i64 high) {
    return {(low - HALF_SUBPIXELS + SUBPIXELS - 1) >> SUBPIXEL_BITS, (high - HALF_SUBPIXELS) >> SUBPIXEL_BITS};
}

static __device__ __forceinline__ i64 min3(i64 a, i64 b, i64 c) { return min(min(a, b), c); }
static __device__ __forceinline__ i64 max3(i64 a, i64 b, i64 c) { return max(max(a, b), c); }
static __device__ __forceinline__ i64 magnitude(i64 a) { return a < 0 ? -a : a; }
static __device__ __forceinline__ int sign(i64 a) { return (a > 0) - (a < 0); }

// Pixels of the image with centres in a box of sub-pixels.
static __device__ __forceinline__ PixelBox pixels_in(const View &view, Range x, Range y) {
    const Range px = pixel_range(x.low, x.high), py = pixel_range(y.low, y.high);
    return {{max(px.low, 0ll), min(px.high, i64(view.size[0]) - 1)}, {max(py.low, 0ll), min(py.high, i64(view.size[1]) - 1)}};
}

// Twice the area of three vertices in square sub-pixels, with the sense of rotation as its sign.
static __device__ __forceinline__ i64 area_of(const Corners &c) {
    const i64 ux = i64(c.v[1].x) - c.v[0].x, uy = i64(c.v[1].y) - c.v[0].y;
    const i64 vx = i64(c.v[2].x) - c.v[0].x, vy = i64(c.v[2].y) - c.v[0].y;
    return ux * vy - uy * vx;
}

// It shows the inside of a solid. Each point of the image that the solid covers is covered by a triangle that faces the eye.
static __device__ __forceinline__ bool faces_away(const Corners &c, int hidden) {
    return hidden != 0 && sign(area_of(c)) == hidden;
}

// Three corners turned so that the area is positive.
struct Triangle {
    i64 x[3], y[3];
    // At the corners: stored depth, or whatever else is interpolated.
    float depth[3];
    i64 area;
    bool turned;

    static __device__ __forceinline__ Triangle of(const Corners &c) {
        Triangle t;
        const i64 area = area_of(c);
        t.turned = area < 0;
        t.area = magnitude(area);
        const Vertex v[3] = {c.v[0], t.turned ? c.v[2] : c.v[1], t.turned ? c.v[1] : c.v[2]};
#pragma unroll
        for (int k = 0; k < 3; k++) {
            t.x[k] = v[k].x;
            t.y[k] = v[k].y;
            t.depth[k] = v[k].depth;
        }
        return t;
    }

    // Edge function of corner k to the next at a point: positive inside.
    __device__ __forceinline__ i64 edge(int k, i64 px, i64 py) const {
        const int n = k == 2 ? 0 : k + 1;
        return (x[n] - x[k]) * (py - y[k]) - (y[n] - y[k]) * (px - x[k]);
    }

    // Points on edge k belong to this triangle: the top-left rule, y down.
    __device__ __forceinline__ bool owns(int k) const {
        const int n = k == 2 ? 0 : k + 1;
        const i64 dx = x[n] - x[k], dy = y[n] - y[k];
        return dy < 0 || (dy == 0 && dx > 0);
    }

    // |dx| + |dy| of edge k.
    __device__ __forceinline__ i64 span(int k) const {
        const int n = k == 2 ? 0 : k + 1;
        return magnitude(x[n] - x[k]) + magnitude(y[n] - y[k]);
    }
};

// The pixel centres that a triangle covers.
struct Coverage {
    PixelBox box;
    Triangle triangle;
    // 1 for edges whose points the top-left rule gives away.
    i64 bias[3];
    // Stored depth of the corner opposite to each edge, over the area.
    float depth[3];

    // Where it may cover centres; most small triangles hold none.
    static __device__ __forceinline__ PixelBox box_of(const View &view, const Corners &c) {
        return pixels_in(view, {min3(c.v[0].x, c.v[1].x, c.v[2].x), max3(c.v[0].x, c.v[1].x, c.v[2].x)},
                         {min3(c.v[0].y, c.v[1].y, c.v[2].y), max3(c.v[0].y, c.v[1].y, c.v[2].y)});
    }

    static __device__ __forceinline__ Coverage of(const Corners &c, const PixelBox &box) {
        Coverage coverage;
        coverage.box = box;
        coverage.triangle = Triangle::of(c);
        const Triangle &t = coverage.triangle;
        const float inverse = 1.0f / float(t.area);
#pragma unroll
        for (int k = 0; k < 3; k++) {
            coverage.depth[k] = t.depth[k == 0 ? 2 : k - 1] * inverse;
            coverage.bias[k] = t.owns(k) ? 0 : 1;
        }
        return coverage;
    }

    // Calls found(x, y, word) for each `step`th of its pixels from the `first` on, row by row.
    template <class Found> __device__ __forceinline__ void each(Word id, int first, int step, Found found) const {
        if (triangle.area == 0) {
            return;
        }
        for (i64 py = box.y.low; py <= box.y.high; py++) {
            for (i64 px = box.x.low + first; px <= box.x.high; px += step) {
                i64 e[3];
#pragma unroll
                for (int k = 0; k < 3; k++) {
                    e[k] = triangle.edge(k, center_of(px), center_of(py));
                }
                if (((e[0] - bias[0]) | (e[1] - bias[1]) | (e[2] - bias[2])) >= 0) {
                    const float d = float(e[0]) * depth[0] + float(e[1]) * depth[1] + float(e[2]) * depth[2];
                    found(int(px), int(py), id | Word(__float_as_uint(d)) << 32);
                }
            }
        }
    }
};

// The larger word stays. Most fragments lose: a plain look is cheaper than the atomic.
static __device__ __forceinline__ void keep_larger(Buffer<Word> words, uint32_t pixel, Word word) {
    if (racy_load(&words[pixel]) < word) {
        atomicMax(&words[pixel], word);
    }
}
