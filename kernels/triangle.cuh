// A triangle on the screen in sub-pixels: edge functions, the top-left rule, coverage. Twin of src/stages/rasterize.rs.
#pragma once
#include "topology.cuh"

using i64 = long long;

constexpr i64 HALF_SUBPIXELS = SUBPIXELS / 2;
constexpr int SUBPIXEL_BITS = 8;
static_assert(1 << SUBPIXEL_BITS == SUBPIXELS);

// First and last.
struct PixelRange {
    i64 low, high;

    __device__ bool empty() const { return low > high; }
};

struct PixelBox {
    PixelRange x, y;

    __device__ bool empty() const { return x.empty() || y.empty(); }
    __device__ i64 pixels() const { return (x.high - x.low + 1) * (y.high - y.low + 1); }
};

// Sub-pixel position of a pixel's centre.
static __device__ __forceinline__ i64 center_of(i64 pixel) { return pixel * SUBPIXELS + HALF_SUBPIXELS; }

// Pixels whose centres lie within [low, high] sub-pixels.
static __device__ __forceinline__ PixelRange pixel_range(i64 low, i64 high) {
    return {(low - HALF_SUBPIXELS + SUBPIXELS - 1) >> SUBPIXEL_BITS, (high - HALF_SUBPIXELS) >> SUBPIXEL_BITS};
}

static __device__ __forceinline__ i64 min3(i64 a, i64 b, i64 c) { return min(min(a, b), c); }
static __device__ __forceinline__ i64 max3(i64 a, i64 b, i64 c) { return max(max(a, b), c); }
static __device__ __forceinline__ i64 magnitude(i64 a) { return a < 0 ? -a : a; }
static __device__ __forceinline__ int sign(i64 a) { return (a > 0) - (a < 0); }

// Pixels of the image with centres in a box of sub-pixels.
static __device__ __forceinline__ PixelBox pixels_in(const View &view, PixelRange x, PixelRange y) {
    const PixelRange px = pixel_range(x.low, x.high), py = pixel_range(y.low, y.high);
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

// Three corners turned so that the area is positive, about an origin. Int is what their products fit.
template <class Int> struct TriangleOf {
    Int x[3], y[3];
    // At the corners: stored depth, or whatever else is interpolated.
    float depth[3];
    Int area;
    bool turned;

    static __device__ __forceinline__ TriangleOf of(const Corners &c, int origin_x = 0, int origin_y = 0) {
        TriangleOf t;
        const i64 area = area_of(c);
        t.turned = area < 0;
        t.area = Int(magnitude(area));
        const Vertex v[3] = {c.v[0], t.turned ? c.v[2] : c.v[1], t.turned ? c.v[1] : c.v[2]};
#pragma unroll
        for (int k = 0; k < 3; k++) {
            t.x[k] = Int(v[k].x) - origin_x;
            t.y[k] = Int(v[k].y) - origin_y;
            t.depth[k] = v[k].depth;
        }
        return t;
    }

    static __device__ __forceinline__ int next(int k) { return k == 2 ? 0 : k + 1; }

    // Edge function of corner k to the next at a point: positive inside.
    __device__ __forceinline__ Int edge(int k, Int px, Int py) const {
        return (x[next(k)] - x[k]) * (py - y[k]) - (y[next(k)] - y[k]) * (px - x[k]);
    }

    // Points on edge k belong to this triangle: the top-left rule, y down.
    __device__ __forceinline__ bool owns(int k) const {
        const Int dx = x[next(k)] - x[k], dy = y[next(k)] - y[k];
        return dy < 0 || (dy == 0 && dx > 0);
    }

    // |dx| + |dy| of edge k.
    __device__ __forceinline__ Int span(int k) const {
        return Int(magnitude(x[next(k)] - x[k]) + magnitude(y[next(k)] - y[k]));
    }
};

using Triangle = TriangleOf<i64>;

namespace coverage {

// Sub-pixels along both axes up to which edge functions about the first corner fit 32 bits: 64 pixels.
constexpr i64 SMALL = 64 * SUBPIXELS;

static __device__ __forceinline__ PixelRange extent(int a, int b, int c) { return {min3(a, b, c), max3(a, b, c)}; }
static __device__ __forceinline__ PixelRange extent_x(const Corners &c) { return extent(c.v[0].x, c.v[1].x, c.v[2].x); }
static __device__ __forceinline__ PixelRange extent_y(const Corners &c) { return extent(c.v[0].y, c.v[1].y, c.v[2].y); }

// Where a triangle may cover pixel centres; most small ones hold none.
static __device__ __forceinline__ PixelBox box_of(const View &view, const Corners &c) {
    return pixels_in(view, extent_x(c), extent_y(c));
}

// Calls found(x, y, word) for the pixels whose centres the triangle covers, in each `step`th column of its box from the
// `first` on.
template <class Int, class Found>
static __device__ __forceinline__ void each_as(const Corners &c, const PixelBox &box, int origin_x, int origin_y, Word id,
                                               int first, int step, Found found) {
    const TriangleOf<Int> t = TriangleOf<Int>::of(c, origin_x, origin_y);
    if (t.area == 0) {
        return;
    }
    const float inverse = 1.0f / float(t.area);
    const Int px = Int(center_of(box.x.low + first) - origin_x), py = Int(center_of(box.y.low) - origin_y);
    // Points on an edge that the top-left rule gives away are outside by one.
    Int row[3], bias[3], along[3], down[3];
    float depth[3];
#pragma unroll
    for (int k = 0; k < 3; k++) {
        const int n = TriangleOf<Int>::next(k);
        row[k] = t.edge(k, px, py);
        bias[k] = t.owns(k) ? 0 : 1;
        along[k] = -(t.y[n] - t.y[k]) * SUBPIXELS * step;
        down[k] = (t.x[n] - t.x[k]) * SUBPIXELS;
        // Of the corner opposite to the edge, over the area.
        depth[k] = t.depth[k == 0 ? 2 : k - 1] * inverse;
    }
    for (int y = int(box.y.low); y <= int(box.y.high); y++) {
        Int e[3] = {row[0], row[1], row[2]};
        for (int x = int(box.x.low) + first; x <= int(box.x.high); x += step) {
            if (((e[0] - bias[0]) | (e[1] - bias[1]) | (e[2] - bias[2])) >= 0) {
                const float d = float(e[0]) * depth[0] + float(e[1]) * depth[1] + float(e[2]) * depth[2];
                found(x, y, id | Word(__float_as_uint(d)) << 32);
            }
#pragma unroll
            for (int k = 0; k < 3; k++) {
                e[k] += along[k];
            }
        }
#pragma unroll
        for (int k = 0; k < 3; k++) {
            row[k] += down[k];
        }
    }
}

// The same within a part of its box.
template <class Found>
static __device__ __forceinline__ void each(const PixelBox &box, const Corners &c, Word id, int first, int step, Found found) {
    const PixelRange x = extent_x(c), y = extent_y(c);
    if (step == 1 && x.high - x.low < SMALL && y.high - y.low < SMALL) {
        each_as<int>(c, box, c.v[0].x, c.v[0].y, id, 0, 1, found);
    } else {
        each_as<i64>(c, box, 0, 0, id, first, step, found);
    }
}

template <class Found>
static __device__ __forceinline__ void each(const View &view, const Corners &c, Word id, int first, int step, Found found) {
    each(box_of(view, c), c, id, first, step, found);
}

} // namespace coverage

// The larger word stays. Most fragments lose: a plain look is cheaper than the atomic.
static __device__ __forceinline__ void keep_larger(Buffer<Word> words, uint32_t pixel, Word word) {
    if (racy_load(&words[pixel]) < word) {
        atomicMax(&words[pixel], word);
    }
}
