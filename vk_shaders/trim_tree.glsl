// Trim loops as kd-trees over monotone segments: which points and boxes of the parameter plane are inside. Twin of
// kernels/trim_tree.cuh; src/scene/trim_tree.rs and trim_segment.rs explain it.

// Points and boxes of the plane are (u, v); a box its lower and upper corner.
struct PlaneBox {
    dvec2 low, high;
};

PlaneBox box_around(dvec2 a, dvec2 b) { return PlaneBox(min(a, b), max(a, b)); }

bool touches(PlaneBox a, PlaneBox b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y;
}

// A segment at work: its ends, from the lower to the upper one, and its homogeneous points.
struct Curve {
    dvec2 a, b;
    uint first, count;
};

Curve curve_of(uint segment) {
    TrimSegment s = push.trims.segments.at[segment];
    return Curve(dvec2(s.ends[0][0], s.ends[0][1]), dvec2(s.ends[1][0], s.ends[1][1]), s.first, s.count);
}

// The point at t, by Horner's scheme in Bernstein form, between the ends whatever rounding does.
dvec2 point_at(Curve c, double t) {
    if (c.count == 0) {
        precise dvec2 straight = c.a + (c.b - c.a) * t;
        return straight;
    }
    precise double s = 1.0LF - t, power = 1.0LF, choose = 1.0LF;
    TrimPoint p = push.trims.points.at[c.first];
    precise dvec3 sum = dvec3(p.x, p.y, p.w);
    uint degree = c.count - 1;
    for (uint k = 1; k <= degree; k++) {
        power = power * t;
        choose = choose * double(degree + 1 - k) / double(k);
        p = push.trims.points.at[c.first + k];
        precise double share = choose * power;
        sum = sum * s + dvec3(p.x, p.y, p.w) * share;
    }
    PlaneBox bounds = box_around(c.a, c.b);
    precise dvec2 point = sum.xy / sum.z;
    return clamp(point, bounds.low, bounds.high);
}

// u of the straight line from a to b at height v, between theirs.
double between(dvec2 a, dvec2 b, double v) {
    double width = b.y - a.y;
    precise double share = width == 0.0LF ? 0.5LF : (v - a.y) / width;
    precise double u = a.x + (b.x - a.x) * share;
    return clamp(u, min(a.x, b.x), max(a.x, b.x));
}

// `greater`: the comparison that is asked for is >, else <.
bool holds(double a, double b, bool greater) { return greater ? a > b : a < b; }

// Evaluations that decide a point's side.
const int STEPS = 128;

// The segment passes the height of p, within its ends', where its u and p's compare so.
bool compares(Curve c, dvec2 p, bool greater) {
    dvec2 a = c.a, b = c.b;
    double ta = 0.0LF, tb = 1.0LF;
    for (int step_ = 0; step_ < STEPS; step_++) {
        // What holds at both brackets holds between them.
        bool here = holds(a.x, p.x, greater);
        if (here == holds(b.x, p.x, greater)) {
            return here;
        }
        if (c.count == 0) {
            break;
        }
        double width = b.y - a.y;
        // Every third step halves: the others may creep.
        bool halve = step_ % 3 == 2 || width <= 0.0LF;
        double share = halve ? 0.5LF : clamp((p.y - a.y) / width, 0.01LF, 0.99LF);
        precise double t = ta + (tb - ta) * share;
        if (t == ta || t == tb) {
            break;
        }
        dvec2 q = point_at(c, t);
        if (q.y <= p.y) {
            ta = t;
            a = q;
        } else {
            tb = t;
            b = q;
        }
    }
    return holds(between(a, b, p.y), p.x, greater);
}

bool passes(Curve c, dvec2 p, bool greater) {
    if (p.y <= c.a.y) {
        return holds(c.a.x, p.x, greater);
    }
    return p.y >= c.b.y ? holds(c.b.x, p.x, greater) : compares(c, p, greater);
}

// The segment has a point in the closed box: the corners across its direction lie on different sides.
bool meets(Curve c, PlaneBox within) {
    if (!touches(box_around(c.a, c.b), within)) {
        return false;
    }
    bool rises = c.b.x >= c.a.x;
    dvec2 left = dvec2(within.low.x, rises ? within.high.y : within.low.y);
    dvec2 right = dvec2(within.high.x, rises ? within.low.y : within.high.y);
    return !passes(c, left, false) && !passes(c, right, true);
}

// The point lies inside the loops of a tree.
bool contains(uint tree, dvec2 p) {
    TrimTree root = push.trims.trees.at[tree];
    // Also refuses what is not a number.
    if (!(root.low[0] <= p.x && p.x < root.high[0] && root.low[1] <= p.y && p.y < root.high[1])) {
        return false;
    }
    TrimNode node = push.trims.nodes.at[root.root];
    while (node.tag < NODE_CELL) {
        node = push.trims.nodes.at[node.first + ((node.tag != 0 ? p.y : p.x) >= node.at ? 1 : 0)];
    }
    bool inside = (node.tag & NODE_INSIDE) != 0;
    uint count = node.tag >> NODE_COUNT_SHIFT;
    for (uint k = 0; k < count; k++) {
        TrimClip clip = push.trims.clips.at[node.first + k];
        bool spans = clip.heights[0] <= p.y && p.y < clip.heights[1];
        bool right = spans && compares(curve_of(clip.segment), p, true);
        bool below = clip.exit != EXIT_NONE && (clip.exit == EXIT_UPPER ? clip.heights[1] : clip.heights[0]) <= p.y;
        inside = inside != (right != below);
    }
    return inside;
}

// Some curve meets a closed box. One bit a level remembers which lower halves are done, and each cell is found from the root
// (Laine, "Restart trail for stackless BVH traversal", 2010).
bool is_crossed(uint tree, PlaneBox within) {
    TrimTree root = push.trims.trees.at[tree];
    if (!touches(PlaneBox(dvec2(root.low[0], root.low[1]), dvec2(root.high[0], root.high[1])), within)) {
        return false;
    }
    uint64_t done = 0ul;
    while (true) {
        uint64_t waiting = 0ul;
        TrimNode node = push.trims.nodes.at[root.root];
        for (uint64_t level = 1ul; node.tag < NODE_CELL; level <<= 1) {
            bool lower = (node.tag != 0 ? within.low.y : within.low.x) <= node.at;
            bool upper = (node.tag != 0 ? within.high.y : within.high.x) >= node.at;
            bool up = !lower || (done & level) != 0ul;
            waiting |= !up && upper ? level : 0ul;
            node = push.trims.nodes.at[node.first + (up ? 1 : 0)];
        }
        uint count = node.tag >> NODE_COUNT_SHIFT;
        for (uint k = 0; k < count; k++) {
            if (meets(curve_of(push.trims.clips.at[node.first + k].segment), within)) {
                return true;
            }
        }
        if (waiting == 0ul) {
            return false;
        }
        // The deepest half that waits is next; all below it starts anew.
        uint high = uint(waiting >> 32);
        uint64_t next = 1ul << (high != 0 ? 32 + findMSB(high) : findMSB(uint(waiting)));
        done = (done & (next - 1ul)) | next;
    }
}

// Where a closed box lies: a `Region`.
uint classify(uint tree, PlaneBox within) {
    if (is_crossed(tree, within)) {
        return REGION_BOUNDARY;
    }
    return contains(tree, within.low * 0.5LF + within.high * 0.5LF) ? REGION_INSIDE : REGION_OUTSIDE;
}
