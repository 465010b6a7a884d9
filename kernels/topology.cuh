// The numbering inside a meshlet: its triangles and outer edges, in the low 7 bits of a visibility word. Twin of
// src/stages/topology.rs.
#pragma once
#include "count.cuh"
#include "evaluate.cuh"

using Word = unsigned long long;

// A block of kernels that give a thread to each pixel, or to each entry of a list: `THREADS` of src/cuda/session.rs.
constexpr int THREADS = 128;
// Blocks of them that a multiprocessor should hold at least, where more would spill registers: 64-bit sums take more of them on
// sm_120.
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 1200
constexpr int BLOCKS = 3;
#else
constexpr int BLOCKS = 4;
#endif

// What the stages that draw read: the frame's patches with their grids, and the vertices that evaluate made of them. In the
// fused frame only what tensor cores made is kept, and null where there is none; others are evaluated where they are wanted.
struct Geometry {
    const View &view;
    Buffer<const Patch> patches;
    Buffer<const Leaf> leaves;
    Buffer<const Point> nets;
    Buffer<const float> basis;
    Buffer<const Meshlet> meshlets;
    Buffer<const Vertex> vertices;
};
// The same as parameters of a kernel: `Geometry` of src/cuda/session.rs passes them in this order.
#define GEOMETRY                                                                                                       \
    const __grid_constant__ View view, Buffer<const Patch> patches, Buffer<const Leaf> leaves, Buffer<const Point> nets, \
        Buffer<const float> basis, Buffer<const Meshlet> meshlets, Buffer<const Vertex> vertices
#define GEOMETRY_ARGUMENTS {view, patches, leaves, nets, basis, meshlets, vertices}

// Three vertices, in their primitive's order.
struct Corners {
    Vertex v[3];
};

namespace topology {

// A vertex of a meshlet's grid.
struct Corner {
    int i, j;
};

// A triangle, or an outer edge with the third vertex of the triangle behind it.
struct Primitive {
    Corner corner[3];
    bool is_edge;
};

// Visibility word of a fragment: the larger wins.
static __device__ __forceinline__ Word word(float depth, uint32_t meshlet, uint32_t index) {
    return Word(__float_as_uint(depth)) << 32 | (meshlet << INDEX_BITS | index);
}

static __device__ __forceinline__ Word with_depth(Word word, float depth) {
    return Word(__float_as_uint(depth)) << 32 | uint32_t(word);
}

static __device__ __forceinline__ float depth_of(Word word) { return __uint_as_float(uint32_t(word >> 32)); }
static __device__ __forceinline__ uint32_t meshlet_of(Word word) { return uint32_t(word) >> INDEX_BITS; }
static __device__ __forceinline__ uint32_t index_of(Word word) { return uint32_t(word) & ((1u << INDEX_BITS) - 1); }

// The first or the second triangle of quad (a, b).
static __device__ __forceinline__ Primitive triangle(int a, int b, int diagonal, int second) {
    const Corner p = {a, b}, q = {a + 1, b}, r = {a + 1, b + 1}, s = {a, b + 1};
    if (diagonal == 0) {
        return second ? Primitive{{p, r, s}, false} : Primitive{{p, q, r}, false};
    }
    return second ? Primitive{{q, r, s}, false} : Primitive{{p, q, s}, false};
}

// Triangles come by quad, v innermost, two a quad.
static __device__ __forceinline__ Primitive triangle(const Meshlet &m, int diagonal, int index) {
    const int quad = index / 2;
    return triangle(quad / m.quads[1], quad % m.quads[1], diagonal, index % 2);
}

static __device__ __forceinline__ int triangles(const Meshlet &m) { return 2 * m.quads[0] * m.quads[1]; }

// Edge k of a side (0: u=0, 1: u=1, 2: v=0, 3: v=1).
static __device__ __forceinline__ Primitive edge(const Meshlet &m, int diagonal, int side, int k) {
    const int a = side == 0 ? 0 : side == 1 ? m.quads[0] - 1 : k;
    const int b = side == 2 ? 0 : side == 3 ? m.quads[1] - 1 : k;
    const Corner p = {a, b}, q = {a + 1, b}, r = {a + 1, b + 1}, s = {a, b + 1};
    const bool main = diagonal == 0;
    switch (side) {
    case 0: return {{p, s, main ? r : q}, true};
    case 1: return {{q, r, main ? p : s}, true};
    case 2: return {{p, q, main ? r : s}, true};
    default: return {{s, r, main ? p : q}, true};
    }
}

static __device__ __forceinline__ int edges(const Meshlet &m, int side) { return m.quads[side < 2 ? 1 : 0]; }

static __device__ __forceinline__ uint32_t edge_index(int side, int k) {
    return FIRST_EDGE + side * EDGES_A_SIDE + k;
}

// Decodes an index.
static __device__ __forceinline__ Primitive primitive(const Meshlet &m, int diagonal, uint32_t index) {
    if (index < FIRST_EDGE) {
        return triangle(m, diagonal, int(index));
    }
    const uint32_t k = index - FIRST_EDGE;
    return edge(m, diagonal, int(k / EDGES_A_SIDE), int(k % EDGES_A_SIDE));
}

static __device__ __forceinline__ Vertex load(const Geometry &in, const Meshlet &m, Corner c) {
    if (in.vertices && m.vertices != NO_VERTICES) {
        return in.vertices[m.vertices + c.i * (m.quads[1] + 1) + c.j];
    }
    return evaluate::vertex(in.view, in.patches[m.patch], in.nets, in.basis, m.first[0] + c.i, m.first[1] + c.j);
}

// The same where it is wanted in many places.
inline __device__ __noinline__ Vertex vertex(const Geometry &in, const Meshlet &m, Corner c) { return load(in, m, c); }

static __device__ __forceinline__ Corners corners(const Geometry &in, const Meshlet &m, const Primitive &p) {
    return {{vertex(in, m, p.corner[0]), vertex(in, m, p.corner[1]), vertex(in, m, p.corner[2])}};
}

// Patch parameters of a vertex of the meshlet's grid.
static __device__ __forceinline__ float2 parameters(const Patch &patch, const Meshlet &m, Corner c) {
    return make_float2(float(uint32_t(m.first[0]) + c.i) / float(patch.quads[0]),
                       float(uint32_t(m.first[1]) + c.j) / float(patch.quads[1]));
}

} // namespace topology
