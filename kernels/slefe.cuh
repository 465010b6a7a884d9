// Yeo's widths of piecewise linear enclosures. Twin of src/stages/slefe.rs, which has the source of the table.
#pragma once
#include "bounds.cuh"

namespace slefe {

// Pieces of the enclosure in each direction.
constexpr int PIECES = 3;

// Upper and lower values at the four break points, three rows a degree from 2 to 7.
static __constant__ double TABLE[18][2][PIECES + 1] = {
    {{0.0, -0.2222222, -0.2222222, 0.0}, {-0.0277779, -0.2500001, -0.2500001, -0.0277779}},
    {},
    {},
    {{0.0, -0.3703704, -0.2962963, 0.0}, {-0.0695216, -0.439892, -0.3153517, -0.008733}},
    {},
    {},
    {{0.0, -0.4691358, -0.3209877, 0.0}, {-0.1170224, -0.5861582, -0.3294661, -0.0023242}},
    {{0.0, -0.5432099, -0.5432099, 0.0}, {-0.0132963, -0.6250001, -0.6250001, -0.0132963}},
    {},
    {{0.0, -0.5349794, -0.3292181, 0.0}, {-0.1655551, -0.7005345, -0.3325541, -0.0005223}},
    {{0.0, -0.7407407, -0.617284, 0.0}, {-0.0791172, -0.8432771, -0.7198203, -1e-07}},
    {},
    {{0.0, -0.5788752, -0.3319616, 0.0}, {-0.2125322, -0.7914074, -0.3331833, -0.0001073}},
    {{0.0, -0.8943759, -0.6474623, 0.0}, {-0.1486372, -1.043013, -0.709172, -1e-07}},
    {{0.0, -0.8806584, -0.8806584, 0.0}, {-1e-07, -1.0312501, -1.0312501, -1e-07}},
    {{0.0, -0.608139, -0.3328761, 0.0}, {-0.2566554, -0.8647944, -0.333302, -2.45e-05}},
    {{0.0, -1.0114312, -0.6593507, 0.0}, {-0.2125215, -1.2239526, -0.6688402, -1e-07}},
    {{0.0, -1.1074531, -0.9474166, 0.0}, {-0.0189769, -1.2836326, -1.123596, -1e-07}},
};

static __device__ __forceinline__ Vec3 zero() { return {0.0, 0.0, 0.0}; }

// What the coefficient j of degree d adds at break point k, where the second difference about it is `difference`.
static __device__ __forceinline__ Vec3 bend(int d, int j, int k, bool upper, Vec3 difference) {
    const bool mirrored = 2 * j > d;
    const int row = 3 * (d - 2) + (mirrored ? d - j : j) - 1, at = mirrored ? PIECES - k : k;
    const double grows = TABLE[row][upper ? 0 : 1][at], shrinks = TABLE[row][upper ? 1 : 0][at];
    return larger(difference, zero()) * grows + lesser(difference, zero()) * shrinks;
}

// Upper (or lower) enclosure value of a row of coefficients `c(j)` of degree d at break point k. Both ends are asked for
// first, then those between: nothing but the last three is kept, and the code of `c` is there once.
template <class Row> static __device__ __forceinline__ Vec3 enclose_row(int d, int k, bool upper, Row c) {
    const double share = double(k) / double(PIECES);
    Vec3 last = zero(), before = zero(), here = zero(), value = zero();
#pragma unroll 1
    for (int step = 0; step <= d; step++) {
        const Vec3 next = c(step == 0 ? 0 : step == 1 ? d : step - 1);
        if (step == 0) {
            here = next;
        } else if (step == 1) {
            last = next;
            value = here * (1.0 - share) + last * share;
        } else {
            if (step > 2) {
                value = value + bend(d, step - 2, k, upper, before - here * 2.0 + next);
            }
            before = here;
            here = next;
        }
    }
    return d > 1 ? value + bend(d, d - 1, k, upper, before - here * 2.0 + last) : value;
}

// Pieces along either direction, squared.
template <int LANES> static __device__ double pieces(const Team<LANES> &team, const bounds::Subject &s) {
    const int m = s.net.degree_u, n = s.net.degree_v;
    const auto camera = [&](int i, int j) {
        const Vec4 p = lens::apply(s.map, s.net.at(i, j));
        return truncated(p) / p.w;
    };
    double pixels = 0.0, depth = 0.0;
    for (int point = team.lane; point < (PIECES + 1) * (PIECES + 1); point += LANES) {
        const int ku = point / (PIECES + 1), kv = point % (PIECES + 1);
        Vec3 corner[2];
#pragma unroll 1
        for (int upper = 0; upper < 2; upper++) {
            const Vec3 found = enclose_row(n, kv, upper != 0, [&](int j) {
                return enclose_row(m, ku, upper != 0, [&](int i) { return camera(i, j); });
            });
            corner[0] = upper ? corner[0] : found;
            corner[1] = found;
        }
        const Vec3 low = corner[0], high = corner[1];
        Vec3 most = zero(), least = zero();
        for (int k = 0; k < 8; k++) {
            const Vec3 c = {k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z};
            const double z = s.view.perspective ? max(c.z, s.view.near) : 1.0;
            const Vec3 p = {s.view.perspective ? c.x / z : c.x, s.view.perspective ? c.y / z : c.y, 0.0};
            most = k ? larger(most, p) : p;
            least = k ? lesser(least, p) : p;
        }
        pixels = max(pixels, larger(most.x - least.x, most.y - least.y));
        depth = max(depth, high.z - low.z);
    }
    const double share = max(team.most(pixels) / (2.0 * s.tolerance), team.most(depth) / (2.0 * s.depth_tolerance));
    return double(PIECES * PIECES) * share;
}

} // namespace slefe
