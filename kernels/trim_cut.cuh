// Part of trim: a patch in the plane of its face's loops, and whether a surface point belongs to the face. Twin of
// src/stages/trim_cut.rs.
#pragma once
#include "newton.cuh"
#include "trim_tree.cuh"

namespace trims {

// Pixels that a face reaches over its own gap at most, so that two faces close one of a pixel; larger ones are shown.
constexpr double MAX_GAP = 0.5;
// Pixels that refinement leaves (1/512), and the rounding of f32 parameters on top of `Leaf::rounding`.
constexpr double REFINED = 1.0 / 512.0 + 1.0 / 1024.0;
// The surface's parameters change up to this many times as fast as its triangle's.
constexpr double BENT = 2.0;

static __device__ __forceinline__ PlanePoint to_plane(const Leaf &leaf, double s, double t) {
    return {leaf.plane_origin[0] + leaf.plane_size[0] * s, leaf.plane_origin[1] + leaf.plane_size[1] * t};
}

static __device__ __forceinline__ Box plane_box(const Leaf &leaf, const double (&low)[2], const double (&high)[2]) {
    return box_around(to_plane(leaf, low[0], low[1]), to_plane(leaf, high[0], high[1]));
}

// Pixels within which a curve with this gap keeps points outside.
static __device__ __forceinline__ double margin(const Leaf &leaf, double gap) {
    return min(gap * leaf.pixels_per_unit, MAX_GAP) + (REFINED + leaf.rounding);
}

struct Spread {
    double s[2];

    __device__ __forceinline__ bool is_finite() const { return s[0] <= 1.7e308 && s[1] <= 1.7e308; }
};

// How far the parameters of a triangle's fragments may be off: as fast as they change across it, along both screen axes
// together, for as many pixels as its grid is off by and a curve of the face reaches. Perspective-correct: the gradient
// grows by the weights' ratio, squared at most.
static __device__ __forceinline__ Spread spread(const Trims &t, const Patch &patch, const Leaf &leaf,
                                                const topology::Primitive &p, const Corners &c) {
    const double reach =
        (double(leaf.deviation[0]) + margin(leaf, t.trees[leaf.tree].gap)) * BENT * double(SUBPIXELS);
    const double ux = double(c.v[1].x) - double(c.v[0].x), uy = double(c.v[1].y) - double(c.v[0].y);
    const double vx = double(c.v[2].x) - double(c.v[0].x), vy = double(c.v[2].y) - double(c.v[0].y);
    const float most = fmaxf(fmaxf(c.v[0].weight, c.v[1].weight), c.v[2].weight);
    const float least = fminf(fminf(c.v[0].weight, c.v[1].weight), c.v[2].weight);
    const double ratio = double(most) / double(least);
    const double inverse = ratio * ratio / fabs(ux * vy - uy * vx);
    const int steps[2][2] = {{p.corner[1].i - p.corner[0].i, p.corner[2].i - p.corner[0].i},
                             {p.corner[1].j - p.corner[0].j, p.corner[2].j - p.corner[0].j}};
    Spread out;
#pragma unroll
    for (int k = 0; k < 2; k++) {
        const double first = steps[k][0], second = steps[k][1];
        out.s[k] = (fabs(first * vy - second * uy) + fabs(second * ux - first * vx)) * inverse * reach /
                   double(patch.quads[k]);
    }
    return out;
}

// Where all lie that the parameters (s, t) may stand for.
static __device__ __forceinline__ uint32_t classify(const Trims &trims, const Leaf &leaf, double s, double t,
                                                    const double (&off)[2]) {
    return classify(trims, leaf.tree, plane_box(leaf, {s - off[0], t - off[1]}, {s + off[0], t + off[1]}));
}

static __device__ __forceinline__ bool contains(const Trims &trims, const Leaf &leaf, double s, double t) {
    return contains(trims, leaf.tree, to_plane(leaf, s, t));
}

// The screen about a refined point by the plane's parameters: pixels in x and in y, depth in units.
struct Image {
    PlanePoint at;
    double du[3], dv[3];

    __device__ __forceinline__ double of(int c, double u, double v) const { return du[c] * (u - at.u) + dv[c] * (v - at.v); }
};

// Some point of the curve is carried by `image` into the box of half sizes `half` about the origin; parts are told apart
// down to an eighth of it. The parts are the halves of halves: the k-th of 2^level.
inline __device__ __noinline__ bool comes_near(const Curve &curve, const Image &image, const double (&half)[3]) {
    // Doubles tell no more halves apart.
    constexpr int LAST = 53;
    uint64_t k = 0;
    int level = 0;
    while (true) {
        const double width = 1.0 / double(1ull << level);
        const double ta = double(k) * width, tb = double(k + 1) * width;
        const PlanePoint a = k == 0 ? curve.a : point_at(curve, ta);
        const PlanePoint b = k + 1 == 1ull << level ? curve.b : point_at(curve, tb);
        bool near = true, small = true, inside_a = true, inside_b = true;
#pragma unroll
        for (int c = 0; c < 3; c++) {
            const double pa = image.of(c, a.u, a.v), pb = image.of(c, b.u, b.v);
            const double pc = image.of(c, a.u, b.v), pd = image.of(c, b.u, a.v);
            const double low = min(min(pa, pb), min(pc, pd)), high = max(max(pa, pb), max(pc, pd));
            // What is not a number is not near.
            near = near && low <= half[c] && high >= -half[c];
            small = small && high - low <= 0.125 * half[c];
            inside_a = inside_a && fabs(pa) <= half[c];
            inside_b = inside_b && fabs(pb) <= half[c];
        }
        if (near && (small || inside_a || inside_b || level == LAST)) {
            return true;
        }
        if (near) {
            k = 2 * k;
            level++;
            continue;
        }
        // The next part that is not done with.
        k++;
        while (level > 0 && k % 2 == 0) {
            k /= 2;
            level--;
        }
        if (level == 0) {
            return false;
        }
    }
}

// Half sizes of a box that holds all (u, v) with |du u + dv v| <= half in each component.
static __device__ __forceinline__ PlanePoint preimage(const Image &image, const double (&half)[3]) {
    const double infinity = __longlong_as_double(0x7ff0000000000000ll);
    PlanePoint reach = {infinity, infinity};
#pragma unroll
    for (int n = 0; n < 3; n++) {
        const int i = n == 2 ? 1 : 0, j = n == 0 ? 1 : 2;
        const double det = fabs(image.du[i] * image.dv[j] - image.dv[i] * image.du[j]);
        const double u = (fabs(image.dv[j]) * half[i] + fabs(image.dv[i]) * half[j]) / det;
        const double v = (fabs(image.du[j]) * half[i] + fabs(image.du[i]) * half[j]) / det;
        // Not where the determinant is zero.
        if (u < infinity && v < infinity) {
            reach = {min(reach.u, u), min(reach.v, v)};
        }
    }
    return reach;
}

// Half sizes of what a curve with this gap keeps on the screen.
static __device__ __forceinline__ void kept(const Leaf &leaf, double gap, double (&half)[3]) {
    half[0] = half[1] = margin(leaf, gap);
    half[2] = double(leaf.depth_tolerance) * (1.0 + half[0]);
}

// Texels a word of a texture.
constexpr uint32_t WORD = 32;

static __device__ __forceinline__ uint32_t words_across(const TrimTexture &texture) { return (texture.size[0] + WORD - 1) / WORD; }

// The texel of a texture at leaf parameters; beyond the unit square the nearest one.
static __device__ __forceinline__ bool contains(const Trims &trims, const TrimTexture &texture, double s, double t) {
    const double x = s * double(texture.size[0]), y = t * double(texture.size[1]);
    const uint32_t column = x > 0.0 ? min(uint32_t(min(x, 65536.0)), texture.size[0] - 1) : 0;
    const uint32_t row = y > 0.0 ? min(uint32_t(min(y, 65536.0)), texture.size[1] - 1) : 0;
    const uint64_t word = texture.first + uint64_t(row) * words_across(texture) + column / WORD;
    return (trims.texels[word] >> column % WORD & 1) != 0;
}

// A point of a leaf that is shown as it is: by its number's texture, if there is one.
static __device__ __forceinline__ bool contains(const Trims &trims, const Leaf &leaf, uint32_t number, double s, double t) {
    return trims.textures ? contains(trims, trims.textures[number], s, t) : contains(trims, leaf, s, t);
}

// A refined point of the leaf with this number is inside the loops, or on the screen within a curve's gap and rounding of one.
inline __device__ __noinline__ bool keeps(const Trims &trims, const View &view, const Leaf &leaf, uint32_t number,
                                          const refinement::Refined &r) {
    if (trims.textures) {
        return contains(trims, trims.textures[number], r.s, r.t);
    }
    const PlanePoint p = to_plane(leaf, r.s, r.t);
    if (contains(trims, leaf.tree, p)) {
        return true;
    }
    if (view.refine == 0) {
        return false;
    }
    Image image;
    image.at = p;
#pragma unroll
    for (int c = 0; c < 3; c++) {
        image.du[c] = double(r.point.ds[c]) / leaf.plane_size[0];
        image.dv[c] = double(r.point.dt[c]) / leaf.plane_size[1];
    }
    double half[3];
    kept(leaf, trims.trees[leaf.tree].gap, half);
    const PlanePoint reach = preimage(image, half);
    const Box within = {{p.u - reach.u, p.v - reach.v}, {p.u + reach.u, p.v + reach.v}};
    return visit(trims, leaf.tree, within, [&](const TrimClip &clip) {
        const Curve curve(trims, clip.segment);
        double half[3];
        kept(leaf, curve.gap, half);
        return curve.bounds().touches(within) && comes_near(curve, image, half);
    });
}

} // namespace trims
