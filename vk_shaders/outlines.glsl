// What is drawn of a meshlet item by item: strokes along its borders and folds, ETER's conservative fragments, triangles that
// reach beyond the viewport. Twin of kernels/outlines.cuh. Hardware gets a shape around each item, fragments are decided exactly.
#include "geometry.glsl"
#include "trim.glsl"

// `Kind` of src/vulkan/pipeline.rs.
const uint FAR = 0, BORDERS = 1, FOLDS = 2, TURNED_AWAY = 3, CONSERVATIVE = 4;
layout(constant_id = 0) const uint KIND = FAR;

struct Drawn {
    uint number;
    Meshlet m;
    uint diagonal;
    int hidden;
};

Drawn drawn_of(uint number) {
    Meshlet m = push.meshlets.at[number];
    return Drawn(number, m, uint(push.patches.at[m.patch_].diagonal), int(push.patches.at[m.patch_].hidden));
}

uint items_of(Drawn d) {
    switch (KIND) {
    case BORDERS: return 4 * EDGES_A_SIDE;
    case FOLDS: return 3 * uint(d.m.quads[0]) * uint(d.m.quads[1]);
    default: return triangles_of(d.m);
    }
}

// The corners of an item that is a triangle, or a border with the triangle behind it.
ivec2[3] places_of(Drawn d, uint item) {
    return KIND == BORDERS ? edge_places(d.m, d.diagonal, item / EDGES_A_SIDE, int(item % EDGES_A_SIDE))
                           : triangle_places(d.m, d.diagonal, item);
}

Corners triangle_of(Drawn d, uint index) { return corners_of(d.m, triangle_places(d.m, d.diagonal, index)); }

// Sense of rotation of a triangle of quad (a, b), in parameter order.
int facing(Drawn d, Meshlet m, ivec2 quad, bool second) {
    return sign_of(area_of(corners_of(m, triangle_places(quad, d.diagonal, second))));
}

// The meshlet of the same patch that follows in u, or in v. They come in parameter order, v innermost.
bool next_of(Drawn d, int axis, out Meshlet next) {
    next = d.m;
    if ((uint(d.m.outer) >> (axis == 0 ? 1 : 3) & 1) != 0) {
        return false;
    }
    uint first[2] = uint[2](uint(d.m.first[0]), uint(d.m.first[1]));
    first[axis] += uint(d.m.quads[axis]);
    for (uint k = d.number + 1; k < push.all && (axis == 0 || k == d.number + 1); k++) {
        next = push.meshlets.at[k];
        if (next.patch_ != d.m.patch_) {
            return false;
        }
        if (uint(next.first[0]) == first[0] && uint(next.first[1]) == first[1]) {
            return true;
        }
    }
    return false;
}

// Two ends of an edge of quad (a, b): kind 0 its diagonal, 1 its side towards the next v, 2 the one towards the next u.
void fold_ends(Drawn d, uint item, out ivec2 quad, out ivec2 from, out ivec2 to) {
    uint kind = item % 3, across = uint(d.m.quads[1]);
    quad = ivec2(item / 3 / across, item / 3 % across);
    bool main_diagonal = d.diagonal == 0;
    from = quad + (kind == 0 ? (main_diagonal ? ivec2(0, 0) : ivec2(1, 0)) : kind == 1 ? ivec2(0, 1) : ivec2(1, 0));
    to = quad + (kind == 0 && !main_diagonal ? ivec2(0, 1) : ivec2(1, 1));
}

// Triangles on both sides of it face different ways.
bool is_fold(Drawn d, uint item, ivec2 quad) {
    uint kind = item % 3;
    if (kind == 0) {
        return facing(d, d.m, quad, false) != facing(d, d.m, quad, true);
    }
    int axis = kind == 1 ? 1 : 0;
    // The triangle on side v = 1 is always the second, on v = 0 the first. Those on u = 1 and u = 0 go by the diagonal.
    bool here = kind == 1 || d.diagonal != 0;
    ivec2 beyond = quad;
    beyond[axis]++;
    Meshlet m = d.m;
    if (beyond[axis] >= int(d.m.quads[axis])) {
        beyond[axis] = 0;
        if (!next_of(d, axis, m)) {
            return false;
        }
    }
    return facing(d, d.m, quad, here) != facing(d, m, beyond, !here);
}

// The segment that an item's pen runs along; its third corner is that of a border's triangle.
Corners segment_of(Drawn d, uint item) {
    if (KIND == BORDERS) {
        return corners_of(d.m, places_of(d, item));
    }
    ivec2 quad, from, to;
    fold_ends(d, item, quad, from, to);
    return corners_of(d.m, ivec2[3](from, to, to));
}

// The pen for it.
int radius_of(Drawn d, uint item, Corners c) {
    if (KIND == FOLDS) {
        return push.leaves.at[d.m.patch_].pen_fold;
    }
    int calm = push.leaves.at[d.m.patch_].pen_sides[item / EDGES_A_SIDE], radius = push.leaves.at[d.m.patch_].pen_radius;
    return calm < radius && may_fold(d.m.patch_, c) ? radius : calm;
}

bool is_border_drawn(Drawn d, uint item, Corners c) {
    // Edges of sides u = 0 and v = 1 come against the parameters' order.
    uint side = item / EDGES_A_SIDE;
    int hidden = side == 0 || side == 3 ? -d.hidden : d.hidden;
    // The surface behind an edge that may fold is seen from both sides.
    return !faces_away(c, hidden) || may_fold(d.m.patch_, c);
}
