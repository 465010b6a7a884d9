// The list of meshlets: grids cut into blocks of up to 7 x 7 quads; those outside the trims are dropped, those that trim curves
// cross are marked. Twin of src/stages/evaluate.rs and `region` in src/stages/trim_cut.rs.
#include "blocks.cuh"
#include "count.cuh"

// A thread a leaf: its blocks, and their vertices.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_counts(Count leaves, Buffer<const Patch> patches, Buffer<uint32_t> blocks, Buffer<uint32_t> vertices) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < leaves.get()) {
        const blocks::Cut u = blocks::cut(patches[k].quads[0]), v = blocks::cut(patches[k].quads[1]);
        blocks[k] = u.count * v.count;
        vertices[k] = (u.quads + u.count) * (v.quads + v.count);
    }
}
KERNEL(meshlet_counts)

// A thread a leaf: its blocks in the order of parameters, as if none were dropped.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_list(Count leaves, Buffer<const Patch> patches, Buffer<const uint32_t> first_blocks,
                 Buffer<const uint32_t> first_vertices, Count all, Buffer<Meshlet> meshlets) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= leaves.get() || !all.fits()) {
        return;
    }
    const blocks::Cut u = blocks::cut(patches[k].quads[0]), v = blocks::cut(patches[k].quads[1]);
    uint32_t vertices = first_vertices[k], number = first_blocks[k];
    for (uint32_t a = 0; a < u.count; a++) {
        for (uint32_t b = 0; b < v.count; b++) {
            const uint32_t quads_u = u.length(a), quads_v = v.length(b);
            const uint32_t outer = (a == 0) | (a + 1 == u.count) << 1 | (b == 0) << 2 | (b + 1 == v.count) << 3;
            meshlets[number++] = {k,
                                  vertices,
                                  {uint16_t(a * u.size), uint16_t(b * v.size)},
                                  {uint8_t(quads_u), uint8_t(quads_v)},
                                  uint8_t(outer),
                                  0};
            vertices += (quads_u + 1) * (quads_v + 1);
        }
    }
}
KERNEL(meshlet_list)

// A thread a block: whether its parameters lie outside the trims. `looked_at` and `vertices`: what evaluate must tell of it.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_drop(Count count, const __grid_constant__ trims::Trims trims, Buffer<const Patch> patches,
                 Buffer<const Leaf> leaves, Buffer<const Meshlet> meshlets, Buffer<uint8_t> states, Buffer<uint32_t> looked_at,
                 Buffer<uint32_t> vertices) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const Meshlet m = meshlets[k];
    const Leaf &leaf = leaves[m.patch];
    uint32_t state = BLOCK_FREE;
    if (leaf.tree != NO_TREE) {
        const uint32_t region = blocks::region_of(trims, leaf, patches[m.patch], m, 0.0, 0.0);
        state = region == REGION_OUTSIDE ? BLOCK_OUTSIDE : BLOCK_CUT;
    }
    states[k] = uint8_t(state);
    looked_at[k] = state == BLOCK_CUT;
    vertices[k] = state == BLOCK_CUT ? blocks::vertices_of(m) : 0;
}
KERNEL(meshlet_drop)

// A thread a block: the blocks to be looked at, with vertices of their own.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_look(Count count, Buffer<const Meshlet> meshlets, Buffer<const uint8_t> states, Buffer<const uint32_t> slots,
                 Buffer<const uint32_t> first_vertices, Count all, Buffer<Meshlet> looked_at, Buffer<uint32_t> numbers) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < count.get() && all.fits() && states[k] == BLOCK_CUT) {
        Meshlet m = meshlets[k];
        m.vertices = first_vertices[k];
        looked_at[slots[k]] = m;
        numbers[slots[k]] = k;
    }
}
KERNEL(meshlet_look)

// A warp a block that is looked at: where it lies, its fragments' errors included.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_region(Count count, const __grid_constant__ trims::Trims trims, Buffer<const Patch> patches,
                   Buffer<const Leaf> leaves, Buffer<const Meshlet> looked_at, Buffer<const uint32_t> numbers,
                   Buffer<const Vertex> vertices, Buffer<Meshlet> meshlets, Buffer<uint8_t> states,
                   Buffer<MeshletCounts> counts) {
    const uint32_t k = (blockIdx.x * blockDim.x + threadIdx.x) / 32;
    if (k >= count.get()) {
        return;
    }
    const Team<32> warp = Team<32>::here();
    const Meshlet m = looked_at[k];
    const Leaf &leaf = leaves[m.patch];
    const Patch &patch = patches[m.patch];
    const double reach = blocks::reach(trims, leaf) * double(SUBPIXELS);
    double u = 0.0, v = 0.0;
    for (uint32_t triangle = warp.lane; triangle < 2u * m.quads[0] * m.quads[1]; triangle += 32) {
        blocks::spread(vertices + m.vertices, m, patch.diagonal, triangle, reach, u, v);
    }
    u = warp.most(u), v = warp.most(v);
    if (warp.lane != 0) {
        return;
    }
    const uint32_t region = blocks::region_of(trims, leaf, patch, m, u, v);
    const uint32_t number = numbers[k];
    if (region == REGION_OUTSIDE) {
        // Evaluated, and dropped only then: neighbours take no notice.
        states[number] = uint8_t(BLOCK_OUTSIDE | BLOCK_CUT);
    } else if (region == REGION_BOUNDARY) {
        meshlets[number].tested = 1;
        atomicAdd(&counts[0].boundary, 1u);
    } else {
        atomicAdd(&counts[0].inside, 1u);
    }
}
KERNEL(meshlet_region)

// A thread a block: whether it is kept, and the vertices it has then. `outer` learns of neighbours that were dropped.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_keep(Count count, Buffer<const Patch> patches, Buffer<Meshlet> meshlets, Buffer<const uint8_t> states,
                 Buffer<uint32_t> kept, Buffer<uint32_t> vertices) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const Meshlet m = meshlets[k];
    kept[k] = states[k] < BLOCK_OUTSIDE;
    vertices[k] = kept[k] ? blocks::vertices_of(m) : 0;
    if (states[k] == BLOCK_FREE) {
        return;
    }
    const uint32_t across = blocks::cut(patches[m.patch].quads[1]).count;
    const auto dropped = [&](uint32_t neighbour) { return states[neighbour] == BLOCK_OUTSIDE; };
    uint32_t outer = m.outer;
    outer |= !(outer & 1) && dropped(k - across) ? 1 : 0;
    outer |= !(outer & 2) && dropped(k + across) ? 2 : 0;
    outer |= !(outer & 4) && dropped(k - 1) ? 4 : 0;
    outer |= !(outer & 8) && dropped(k + 1) ? 8 : 0;
    meshlets[k].outer = uint8_t(outer);
}
KERNEL(meshlet_keep)

// A thread a block: the final list.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_compact(Count count, Buffer<const Meshlet> from, Buffer<const uint8_t> states, Buffer<const uint32_t> slots,
                    Buffer<const uint32_t> first_vertices, Count all, Buffer<Meshlet> to) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < count.get() && all.fits() && states[k] < BLOCK_OUTSIDE) {
        Meshlet m = from[k];
        m.vertices = first_vertices[k];
        to[slots[k]] = m;
    }
}
KERNEL(meshlet_compact)

// A thread a meshlet of the final list: quads of all.
extern "C" __global__ void __launch_bounds__(128)
    meshlet_quads(Count count, Buffer<const Meshlet> meshlets, Buffer<MeshletCounts> counts) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    const uint32_t quads = k < count.get() ? uint32_t(meshlets[k].quads[0]) * meshlets[k].quads[1] : 0;
    const uint32_t sum = __reduce_add_sync(~0u, quads);
    if (threadIdx.x % 32 == 0 && sum > 0) {
        atomicAdd(reinterpret_cast<unsigned long long *>(&counts[0].quads), (unsigned long long)sum);
    }
}
KERNEL(meshlet_quads)
