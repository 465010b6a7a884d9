// Fragments that may close a crack: border strokes, and ETER's conservative ones (DESIGN section 4; research
// "crack-closing", section 2, rules 1 to 4). Twin of src/stages/stroke.rs.
#pragma once
#include "triangle.cuh"

namespace stroke {

// Depth is pushed back by a pen's width of slope and this many pixels.
constexpr float PUSH_MARGIN = 1.0f / 64.0f;
// Strokes lose against what they continue: a few f32 roundings.
constexpr float PUSH_FACTOR = 1.0f - 2e-6f;
// Derivatives of what a grid is off by, a quad's side, for each pixel of it.
constexpr double STEEPEST = 8.0;
constexpr float LEAST_DEPTH = 1.17549435e-38f;

static __device__ __forceinline__ Word at_depth(Word id, float depth) {
    return id | Word(__float_as_uint(fmaxf(depth, LEAST_DEPTH))) << 32;
}

// The image of the surface over a triangle may have a fold, where its grid is off by `off` pixels: `may_fold` of the CPU.
static __device__ __forceinline__ bool may_fold(const Corners &c, float off) {
    const double ux = double(i64(c.v[1].x) - c.v[0].x), uy = double(i64(c.v[1].y) - c.v[0].y);
    const double vx = double(i64(c.v[2].x) - c.v[0].x), vy = double(i64(c.v[2].y) - c.v[0].y);
    const double wx = double(i64(c.v[2].x) - c.v[1].x), wy = double(i64(c.v[2].y) - c.v[1].y);
    const double longest2 = fmax(fmax(ux * ux + uy * uy, vx * vx + vy * vy), wx * wx + wy * wy);
    return fabs(ux * vy - uy * vx) <= STEEPEST * double(off) * double(SUBPIXELS) * sqrt(longest2);
}

static __device__ __forceinline__ bool may_fold(const Leaf &leaf, const Corners &c) {
    return leaf.pen_fold > 0 && may_fold(c, leaf.deviation[0]);
}

// Where on a segment the nearest point lies: projection over squared length, clamped.
static __device__ __forceinline__ float nearest(i64 dot, i64 length2) {
    return length2 == 0 ? 0.0f : fminf(fmaxf(float(dot) / float(length2), 0.0f), 1.0f);
}

// A segment that a square pen runs along; sub-pixels, the radius in L-infinity.
struct Segment {
    i64 ax, ay, dx, dy, radius;

    static __device__ __forceinline__ Segment between(const Vertex &a, const Vertex &b, i64 radius) {
        return {a.x, a.y, i64(b.x) - a.x, i64(b.y) - a.y, radius};
    }

    __device__ __forceinline__ PixelBox box(const View &view) const {
        return pixels_in(view, {min(ax, ax + dx) - radius, max(ax, ax + dx) + radius},
                         {min(ay, ay + dy) - radius, max(ay, ay + dy) + radius});
    }

    // Calls paint(x, y, side, s) for the pixels in each `step`th row from the `first` on whose centres the pen meets: `side`
    // is positive to the right of the way (y runs down), `s` in [0, 1] says where on the segment the nearest point lies.
    template <class Paint> __device__ __forceinline__ void each(const PixelBox &box, int first, int step, Paint paint) const {
        const i64 reach = radius * (magnitude(dx) + magnitude(dy));
        const i64 length2 = dx * dx + dy * dy;
        for (i64 y = box.y.low + first; y <= box.y.high; y += step) {
            const i64 py = center_of(y) - ay;
            i64 low = box.x.low, high = box.x.high;
            if (dy != 0) {
                // Long slanted edges: only what lies between the two parallels, and a pixel to spare for rounding.
                const i64 a = (dx * py - reach) / dy, b = (dx * py + reach) / dy;
                low = max(low, ((min(a, b) + ax - HALF_SUBPIXELS) >> SUBPIXEL_BITS) - 1);
                high = min(high, ((max(a, b) + ax - HALF_SUBPIXELS) >> SUBPIXEL_BITS) + 2);
            }
            for (i64 x = low; x <= high; x++) {
                const i64 px = center_of(x) - ax;
                const i64 side = dx * py - dy * px;
                if (magnitude(side) <= reach) {
                    paint(int(x), int(y), side, nearest(dx * px + dy * py, length2));
                }
            }
        }
    }
};

// Rule 4: a pen's width of the triangle's slope, at most the size of its depth range.
static __device__ __forceinline__ float push(const Corners &corners, i64 area, const Leaf &leaf) {
    const Vertex &a = corners.v[0], &b = corners.v[1], &c = corners.v[2];
    const float range = fmaxf(fmaxf(a.depth, b.depth), c.depth) - fminf(fminf(a.depth, b.depth), c.depth);
    if (area == 0) {
        return range;
    }
    const float u = b.depth - a.depth, v = c.depth - a.depth;
    const float ux = float(b.x - a.x), uy = float(b.y - a.y);
    const float vx = float(c.x - a.x), vy = float(c.y - a.y);
    const float per_pixel = float(SUBPIXELS) / float(magnitude(area));
    const float slope = (fabsf(u * vy - v * uy) + fabsf(v * ux - u * vx)) * per_pixel;
    const float width = 2.0f * float(leaf.pen_radius) / float(SUBPIXELS) + PUSH_MARGIN;
    return fminf(slope * width, range);
}

// Calls found(x, y, word) for a stroke along corner 0 to corner 1; corner 2 completes the triangle behind it.
template <class Found>
static __device__ __forceinline__ void border(const View &view, const Leaf &leaf, const Corners &c, int side, Word id,
                                              int first, int step, Found found) {
    const int calm = leaf.pen_sides[side];
    const int radius = calm < leaf.pen_radius && may_fold(leaf, c) ? leaf.pen_radius : calm;
    const Segment segment = Segment::between(c.v[0], c.v[1], radius);
    const i64 area = area_of(c);
    const float back = leaf.pen_fold > 0 ? 0.0f : push(c, area, leaf);
    const float from = c.v[0].depth, rise = c.v[1].depth - c.v[0].depth;
    segment.each(segment.box(view), first, step, [&](int x, int y, i64 side, float s) {
        // Only the outer side: inside, the triangle's own fragments say it better.
        if (side * sign(area) <= 0) {
            found(x, y, at_depth(id, (from + rise * s - back) * PUSH_FACTOR));
        }
    });
}

// The same along an edge at which the grid folds over, on both sides.
template <class Found>
static __device__ __forceinline__ void fold(const View &view, const Leaf &leaf, const Vertex &a, const Vertex &b, Word id,
                                            int first, int step, Found found) {
    const Segment segment = Segment::between(a, b, leaf.pen_fold);
    segment.each(segment.box(view), first, step, [&](int x, int y, i64, float s) {
        found(x, y, at_depth(id, (a.depth + (b.depth - a.depth) * s) * PUSH_FACTOR));
    });
}

struct Weights {
    float w[3];
};

// Barycentric weights of the triangle's point nearest to (px, py), which is not inside.
static __device__ __forceinline__ Weights nearest_in_triangle(const Triangle &t, i64 px, i64 py) {
    Weights best = {{0.0f, 0.0f, 0.0f}};
    // 2^63: farther than any.
    double least = 9223372036854775807.0;
#pragma unroll
    for (int k = 0; k < 3; k++) {
        const int n = k == 2 ? 0 : k + 1;
        const i64 dx = t.x[n] - t.x[k], dy = t.y[n] - t.y[k];
        const float s = nearest(dx * (px - t.x[k]) + dy * (py - t.y[k]), dx * dx + dy * dy);
        const double x = double(t.x[k]) + double(dx) * double(s) - double(px);
        const double y = double(t.y[k]) + double(dy) * double(s) - double(py);
        const double distance = x * x + y * y;
        if (distance < least) {
            best = {{0.0f, 0.0f, 0.0f}};
            best.w[k] = 1.0f - s;
            best.w[n] = s;
            least = distance;
        }
    }
    return best;
}

// ETER section 6.1: pixels whose square the triangle touches without holding the centre. Depth is that of the triangle's
// nearest point: extrapolating slides along slivers by many pixels.
template <class Found>
static __device__ __forceinline__ void conservative(const View &view, const Corners &c, Word id, int first, int step,
                                                    Found found) {
    const Triangle t = Triangle::of(c);
    const PixelBox box = pixels_in(
        view, {min3(t.x[0], t.x[1], t.x[2]) - HALF_SUBPIXELS, max3(t.x[0], t.x[1], t.x[2]) + HALF_SUBPIXELS},
        {min3(t.y[0], t.y[1], t.y[2]) - HALF_SUBPIXELS, max3(t.y[0], t.y[1], t.y[2]) + HALF_SUBPIXELS});
    for (i64 y = box.y.low; y <= box.y.high; y++) {
        for (i64 x = box.x.low + first; x <= box.x.high; x += step) {
            bool inside = t.area > 0, touches = true;
#pragma unroll
            for (int k = 0; k < 3; k++) {
                const i64 e = t.edge(k, center_of(x), center_of(y));
                inside = inside && (e > 0 || (e == 0 && t.owns(k)));
                touches = touches && e >= -HALF_SUBPIXELS * t.span(k);
            }
            if (touches && !inside) {
                const Weights weights = nearest_in_triangle(t, center_of(x), center_of(y));
                // A sum of f32 in Rust begins with -0, which changes nothing.
                const float depth = weights.w[0] * t.depth[0] + weights.w[1] * t.depth[1] + weights.w[2] * t.depth[2];
                found(int(x), int(y), at_depth(id, depth));
            }
        }
    }
}

} // namespace stroke
