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

// Upper (or lower) enclosure value of a row of coefficients `c(j)` of degree d at break point k. Each coefficient may be
// asked for several times: nothing is kept.
template <class Row> static __device__ Vec3 enclose_row(int d, int k, bool upper, Row c) {
    const double share = double(k) / double(PIECES);
    const Vec3 first = c(0);
    Vec3 before = first, here = c(1);
    const Vec3 last = d > 1 ? c(d) : here;
    Vec3 value = first * (1.0 - share) + last * share;
    for (int j = 1; j < d; j++) {
        const Vec3 next = j + 1 < d ? c(j + 1) : last;
        const Vec3 difference = before - here * 2.0 + next;
        const bool mirrored = 2 * j > d;
        const double(&row)[2][PIECES + 1] = TABLE[3 * (d - 2) + (mirrored ? d - j : j) - 1];
        const int at = mirrored ? PIECES - k : k;
        const double grows = row[upper ? 0 : 1][at], shrinks = row[upper ? 1 : 0][at];
        value = value + (larger(difference, zero()) * grows + lesser(difference, zero()) * shrinks);
        before = here;
        here = next;
    }
    return value;
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
        const auto corner_of = [&](bool upper) {
            return enclose_row(n, kv, upper, [&](int j) {
                return enclose_row(m, ku, upper, [&](int i) { return camera(i, j); });
            });
        };
        const Vec3 high = corner_of(true), low = corner_of(false);
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
