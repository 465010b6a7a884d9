// trim: a fragment of a meshlet that a trim curve crosses is kept, left out, or listed, to be tested on the exact surface
// (DESIGN section 5). Twin of kernels/trim.cu and trim_cut.cuh.
#include "interpolate.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Trees { TrimTree at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Nodes { TrimNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Clips { TrimClip at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Segments { TrimSegment at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Points { TrimPoint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Fragments { Fragment at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Count { uint64_t fragments; };

// `Trims` of src/vulkan/trims.rs.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Trims {
    Trees trees;
    Nodes nodes;
    Clips clips;
    Segments segments;
    Points points;
    // What could not be decided here: as many as there is room for, and how many there would have been.
    Fragments queue;
    Count count;
    uint room;
    // Fragments stay as they are, and so their own parameters are tested.
    uint alone;
};

#include "trim_tree.glsl"

// Pixels that a face reaches over its own gap at most, so that two faces close one of a pixel; larger ones are shown.
const double MAX_GAP = 0.5LF;
// Pixels that refinement leaves (1/512), and the rounding of f32 parameters on top of `Leaf::rounding`.
const double REFINED = 1.0LF / 512.0LF + 1.0LF / 1024.0LF;
// The surface's parameters change up to this many times as fast as its triangle's.
const double BENT = 2.0LF;

dvec2 to_plane(Leaf leaf, dvec2 s) {
    precise dvec2 p = dvec2(leaf.plane_origin[0], leaf.plane_origin[1]) + dvec2(leaf.plane_size[0], leaf.plane_size[1]) * s;
    return p;
}

// How far the parameters of a triangle's fragments may be off: as fast as they change across it, along both screen axes
// together, for as many pixels as its grid is off by and a curve of the face reaches.
dvec2 spread_of(Leaf leaf, Meshlet m, ivec2 places[3], Corners c) {
    double margin = min(push.trims.trees.at[leaf.tree].gap * leaf.pixels_per_unit, MAX_GAP) + (REFINED + leaf.rounding);
    double reach = (double(leaf.deviation[0]) + margin) * BENT * double(SUBPIXELS);
    dvec2 u = dvec2(c.at[1]) - dvec2(c.at[0]), v = dvec2(c.at[2]) - dvec2(c.at[0]);
    vec3 weights = vec3(weight_of(m, places[0]), weight_of(m, places[1]), weight_of(m, places[2]));
    double ratio = double(max(max(weights.x, weights.y), weights.z)) / double(min(min(weights.x, weights.y), weights.z));
    double inverse = ratio * ratio / abs(u.x * v.y - u.y * v.x);
    precise dvec2 off;
    [[unroll]] for (int k = 0; k < 2; k++) {
        double first = double(places[1][k] - places[0][k]), second = double(places[2][k] - places[0][k]);
        off[k] = (abs(first * v.y - second * u.y) + abs(second * u.x - first * v.x)) * inverse * reach
                 / double(uint(push.patches.at[m.patch_].quads[k]));
    }
    return off;
}

// Where all lie that the parameters may stand for.
uint classify(Leaf leaf, dvec2 s, dvec2 off) {
    return classify(leaf.tree, box_around(to_plane(leaf, s - off), to_plane(leaf, s + off)));
}

// Where all fragments of a triangle lie, their errors included.
uint region_of(Meshlet m, ivec2 places[3], Corners c) {
    Leaf leaf = push.leaves.at[m.patch_];
    ivec2 first = ivec2(m.first[0], m.first[1]);
    dvec2 quads = dvec2(uint(push.patches.at[m.patch_].quads[0]), uint(push.patches.at[m.patch_].quads[1]));
    dvec2 low = dvec2(first + min(min(places[0], places[1]), places[2])) / quads;
    dvec2 high = dvec2(first + max(max(places[0], places[1]), places[2])) / quads;
    dvec2 off = spread_of(leaf, m, places, c);
    return classify(leaf.tree, box_around(to_plane(leaf, low - off), to_plane(leaf, high + off)));
}

// A triangle's fragment, in a pixel whose centre it covers.
void trim(Meshlet m, ivec2 places[3], Corners c, ivec2 pixel, uint64_t word) {
    if (push.near.at[uint(pixel.y) * push.size[0] + uint(pixel.x)] >= word) {
        return;
    }
    Leaf leaf = push.leaves.at[m.patch_];
    uint region = classify(leaf, dvec2(in_triangle(m, places, c, pixel)), spread_of(leaf, m, places, c));
    if (region == REGION_INSIDE) {
        keep_larger(push.near, pixel, word);
    } else if (region == REGION_BOUNDARY) {
        uint64_t place = atomicAdd(push.trims.count.fragments, 1ul);
        if (place < push.trims.room) {
            push.trims.queue.at[uint(place)] = Fragment(word, uint(pixel.y) * push.size[0] + uint(pixel.x), 0);
        }
    }
}

// A fragment for the spare buffer. One that stays as it is shows its own parameters, so that these are tested; one that only
// proposes a pixel is refused where nothing of the face is near. `edge`: on a border.
bool keeps_stroke(Meshlet m, ivec2 places[3], Corners c, ivec2 pixel, bool edge) {
    Leaf leaf = push.leaves.at[m.patch_];
    dvec2 s = dvec2(edge ? on_edge(m, places, c, pixel) : in_triangle(m, places, c, pixel));
    if (push.trims.alone != 0) {
        return contains(leaf.tree, to_plane(leaf, s));
    }
    // Edge-on there is no telling.
    if (area_of(c) == 0) {
        return true;
    }
    // The pen's width, and as much again to what lies under the pixel's centre.
    dvec2 off = 2.0LF * spread_of(leaf, m, places, c);
    return classify(leaf, s, off) != REGION_OUTSIDE;
}
