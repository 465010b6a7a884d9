// What shaders are told, and the numbering inside a meshlet. Twin of kernels/topology.cuh and kernels/triangle.cuh.
#extension GL_EXT_mesh_shader : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_spirv_intrinsics : require
#include "abi.glsl"

// RoundingModeRTE: f32 rounds to nearest, also from integers, which is not promised otherwise.
spirv_execution_mode(capabilities = [4467], 4462, 32);

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Patches { Patch at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Leaves { Leaf at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Meshlets { Meshlet at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Vertices { Vertex at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Numbers { uint at[]; };
// Others may write what is read here.
layout(buffer_reference, scalar, buffer_reference_align = 8) volatile buffer Words { uint64_t at[]; };

// vk_shaders/trim.glsl has the rest.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Trims;

// `Push` of src/vulkan/pipeline.rs.
layout(push_constant, scalar) uniform Pushed {
    Patches patches;
    Leaves leaves;
    Meshlets meshlets;
    Vertices vertices;
    Numbers numbers;
    Words near;
    Words spare;
    Trims trims;
    uint first;
    uint count;
    uint all;
    uint size[2];
    int middle[2];
    int half_viewport;
    // One over it, which is a power of two: no division has to be exact.
    float scale;
} push;

// Trim curves cross what is drawn.
layout(constant_id = 1) const bool TRIMMED = false;

const int64_t HALF_SUBPIXELS = SUBPIXELS / 2;

// A workgroup's meshlet, and which part of its items.
uvec2 job_at(uint place) {
    uint job = push.numbers.at[place];
    return uvec2(job & ((1u << (32 - INDEX_BITS)) - 1), job >> (32 - INDEX_BITS));
}

// Three vertices, in their primitive's order: sub-pixels and depths.
struct Corners {
    ivec2 at[3];
    float depth[3];
};

Vertex vertex_of(Meshlet m, ivec2 corner) {
    return push.vertices.at[m.vertices + corner.x * (uint(m.quads[1]) + 1) + corner.y];
}

Corners corners_of(Meshlet m, ivec2 places[3]) {
    Corners c;
    [[unroll]] for (int k = 0; k < 3; k++) {
        Vertex v = vertex_of(m, places[k]);
        c.at[k] = ivec2(v.x, v.y);
        c.depth[k] = v.depth;
    }
    return c;
}

// The first or the second triangle of quad (a, b), as places in the meshlet's grid.
ivec2[3] triangle_places(ivec2 quad, uint diagonal, bool second) {
    ivec2 p = quad, q = quad + ivec2(1, 0), r = quad + ivec2(1, 1), s = quad + ivec2(0, 1);
    if (diagonal == 0) {
        return second ? ivec2[3](p, r, s) : ivec2[3](p, q, r);
    }
    return second ? ivec2[3](q, r, s) : ivec2[3](p, q, s);
}

// Triangles come by quad, v innermost, two a quad.
ivec2[3] triangle_places(Meshlet m, uint diagonal, uint index) {
    uint quad = index / 2, across = uint(m.quads[1]);
    return triangle_places(ivec2(quad / across, quad % across), diagonal, (index & 1) != 0);
}

uint triangles_of(Meshlet m) { return 2 * uint(m.quads[0]) * uint(m.quads[1]); }

// Edge k of a side (0: u=0, 1: u=1, 2: v=0, 3: v=1), and the third corner of the triangle behind it.
ivec2[3] edge_places(Meshlet m, uint diagonal, uint side, int k) {
    ivec2 quads = ivec2(m.quads[0], m.quads[1]);
    ivec2 p = ivec2(side == 0 ? 0 : side == 1 ? quads.x - 1 : k, side == 2 ? 0 : side == 3 ? quads.y - 1 : k);
    ivec2 q = p + ivec2(1, 0), r = p + ivec2(1, 1), s = p + ivec2(0, 1);
    bool main_diagonal = diagonal == 0;
    switch (side) {
    case 0: return ivec2[3](p, s, main_diagonal ? r : q);
    case 1: return ivec2[3](q, r, main_diagonal ? p : s);
    case 2: return ivec2[3](p, q, main_diagonal ? r : s);
    default: return ivec2[3](s, r, main_diagonal ? p : q);
    }
}

// Twice the area in square sub-pixels, with the sense of rotation as its sign.
int64_t area_of(Corners c) {
    i64vec2 u = i64vec2(c.at[1]) - i64vec2(c.at[0]), v = i64vec2(c.at[2]) - i64vec2(c.at[0]);
    return u.x * v.y - u.y * v.x;
}

int sign_of(int64_t a) { return int(a > 0) - int(a < 0); }

// It shows the inside of a solid.
bool faces_away(Corners c, int hidden) { return hidden != 0 && sign_of(area_of(c)) == hidden; }

// Pixels, first and last in x and in y.
struct PixelBox {
    ivec2 low, high;
};

bool is_empty(PixelBox box) { return box.low.x > box.high.x || box.low.y > box.high.y; }

// Pixels of the image with centres in a box of sub-pixels.
PixelBox pixels_in(i64vec2 low, i64vec2 high) {
    ivec2 from = ivec2((low - HALF_SUBPIXELS + int64_t(SUBPIXELS - 1)) >> 8);
    ivec2 to = ivec2((high - HALF_SUBPIXELS) >> 8);
    return PixelBox(max(from, ivec2(0)), min(to, ivec2(push.size[0], push.size[1]) - 1));
}

// Where a triangle may cover pixel centres, or with half a pixel more.
PixelBox box_of(Corners c, int64_t more) {
    return pixels_in(i64vec2(min(min(c.at[0], c.at[1]), c.at[2])) - more, i64vec2(max(max(c.at[0], c.at[1]), c.at[2])) + more);
}

// It reaches beyond what a viewport shows exactly.
bool is_far(ivec2 at) {
    ivec2 from_middle = abs(at - ivec2(push.middle[0], push.middle[1]) * SUBPIXELS);
    return max(from_middle.x, from_middle.y) > (push.half_viewport - 1) * SUBPIXELS;
}

bool is_far(Corners c) { return is_far(c.at[0]) || is_far(c.at[1]) || is_far(c.at[2]); }

// Clip coordinates of a place in pixels: exact, since the viewport's side is a power of two and its middle a whole pixel.
vec4 clip_of(vec2 pixels) {
    return vec4((pixels - vec2(push.middle[0], push.middle[1])) * push.scale, 0.5, 1.0);
}

i64vec2 center_of(ivec2 pixel) { return i64vec2(pixel) * int64_t(SUBPIXELS) + HALF_SUBPIXELS; }

uint64_t word_of(float depth, uint low) { return uint64_t(floatBitsToUint(depth)) << 32 | uint64_t(low); }

float depth_of(uint64_t word) { return uintBitsToFloat(uint(word >> 32)); }

// The larger word stays. Most fragments lose: a plain look is cheaper than the atomic.
void keep_larger(Words words, ivec2 pixel, uint64_t word) {
    uint at = uint(pixel.y) * push.size[0] + uint(pixel.x);
    if (words.at[at] < word) {
        atomicMax(words.at[at], word);
    }
}
