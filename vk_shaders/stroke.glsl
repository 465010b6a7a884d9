// Fragments that may close a crack: border strokes, and ETER's conservative ones (DESIGN section 4). Twin of kernels/stroke.cuh.
#include "coverage.glsl"

// Depth is pushed back by a pen's width of slope and this many pixels.
const float PUSH_MARGIN = 1.0 / 64.0;
// Strokes lose against what they continue: a few f32 roundings. 1 - 2e-6 in f32.
const float PUSH_FACTOR = 1.0 - 2e-6;
// Derivatives of what a grid is off by, a quad's side, for each pixel of it.
const double STEEPEST = 8.0LF;
const float LEAST_DEPTH = 1.17549435e-38;

// The image of the surface over a triangle may have a fold, where its grid is off by so many pixels: `may_fold` of the CPU.
bool may_fold(uint leaf, Corners c) {
    if (push.leaves.at[leaf].pen_fold <= 0) {
        return false;
    }
    dvec2 u = dvec2(c.at[1]) - dvec2(c.at[0]), v = dvec2(c.at[2]) - dvec2(c.at[0]), w = dvec2(c.at[2]) - dvec2(c.at[1]);
    precise double uu = u.x * u.x + u.y * u.y, vv = v.x * v.x + v.y * v.y, ww = w.x * w.x + w.y * w.y;
    precise double area = u.x * v.y - u.y * v.x;
    precise double least = STEEPEST * double(push.leaves.at[leaf].deviation[0]) * double(SUBPIXELS) * sqrt(max(max(uu, vv), ww));
    return abs(area) <= least;
}

// Where on a segment the nearest point lies: projection over squared length, clamped.
float nearest_on(int64_t along, int64_t length2) {
    return length2 == 0 || along <= 0 ? 0.0 : along >= length2 ? 1.0 : min(quotient(float(along), float(length2)), 1.0);
}

// A segment from a to b, met by a square pen at a pixel's centre: `side` is positive to the right of the way (y runs down),
// `s` in [0, 1] says where on it the nearest point lies. All in sub-pixels.
bool meets(ivec2 from, ivec2 to, int radius, ivec2 pixel, out int64_t side, out float s) {
    i64vec2 a = i64vec2(from), way = i64vec2(to) - a, p = center_of(pixel) - a;
    int64_t r = int64_t(radius);
    i64vec2 low = min(i64vec2(0), way) - r, high = max(i64vec2(0), way) + r;
    side = way.x * p.y - way.y * p.x;
    s = nearest_on(way.x * p.x + way.y * p.y, way.x * way.x + way.y * way.y);
    bool boxed = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
    return boxed && abs(side) <= r * (abs(way.x) + abs(way.y));
}

// Rule 4: a pen's width of the triangle's slope, at most the size of its depth range.
float push_of(uint leaf, Corners c, int64_t area) {
    float range = max(max(c.depth[0], c.depth[1]), c.depth[2]) - min(min(c.depth[0], c.depth[1]), c.depth[2]);
    if (area == 0) {
        return range;
    }
    vec2 u = vec2(c.at[1] - c.at[0]), v = vec2(c.at[2] - c.at[0]);
    precise float du = c.depth[1] - c.depth[0], dv = c.depth[2] - c.depth[0];
    precise float slope = (abs(du * v.y - dv * u.y) + abs(dv * u.x - du * v.x)) * quotient(float(SUBPIXELS), float(abs(area)));
    precise float width = 2.0 * float(push.leaves.at[leaf].pen_radius) / float(SUBPIXELS) + PUSH_MARGIN;
    precise float push_back = slope * width;
    return min(push_back, range);
}

// Barycentric weights of the triangle's point nearest to a pixel's centre, which is not inside.
float[3] nearest_weights(Corners c, ivec2 pixel) {
    i64vec2 p = center_of(pixel);
    float best[3];
    double least = 0.0LF;
    [[unroll]] for (int k = 0; k < 3; k++) {
        int n = (k + 1) % 3;
        i64vec2 way = i64vec2(c.at[n]) - i64vec2(c.at[k]), to = p - i64vec2(c.at[k]);
        float s = nearest_on(way.x * to.x + way.y * to.y, way.x * way.x + way.y * way.y);
        precise double x = double(c.at[k].x) + double(way.x) * double(s) - double(p.x);
        precise double y = double(c.at[k].y) + double(way.y) * double(s) - double(p.y);
        precise double distance2 = x * x + y * y;
        if (k == 0 || distance2 < least) {
            best = float[3](0.0, 0.0, 0.0);
            best[k] = 1.0 - s;
            best[n] = s;
            least = distance2;
        }
    }
    return best;
}

// A pixel whose square the triangle touches without holding the centre (ETER section 6.1).
bool touches(Corners given, int64_t area, ivec2 pixel, out float depth) {
    Corners c = turned(given, area);
    bool inside = area != 0, meets_all = true;
    [[unroll]] for (int k = 0; k < 3; k++) {
        int64_t e = edge_at(c, k, center_of(pixel));
        i64vec2 way = abs(i64vec2(c.at[(k + 1) % 3]) - i64vec2(c.at[k]));
        inside = inside && (e > 0 || (e == 0 && owns(c, k)));
        meets_all = meets_all && e >= -HALF_SUBPIXELS * (way.x + way.y);
    }
    float weights[3] = nearest_weights(c, pixel);
    precise float d = weights[0] * c.depth[0] + weights[1] * c.depth[1] + weights[2] * c.depth[2];
    depth = d;
    return meets_all && !inside;
}
