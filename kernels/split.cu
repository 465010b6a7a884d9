// The leaves of patches that are not drawn as a whole: too near or too large for the later stages, or drawn with fewer quads in
// parts. Second half of src/stages/cull.rs and estimate.rs.
#include "count.cuh"
#include "halves.cuh"

namespace split {

// Leaves that one patch may be split into.
constexpr uint32_t MAX_LEAVES = 1 << 20;
// Leaves beyond which the host gives up: each has four vertices at least.
constexpr uint32_t MAX_PARTS = 1 << 26;

// What a launch is given, besides the scene and the view.
struct Buffers {
    Buffer<const Visible> visible;
    // Which of them are to be split.
    Buffer<const uint32_t> work;
    Buffer<Counters> counters;
    // By visible patch: its leaves and their control points.
    Buffer<uint32_t> leaf_counts, point_counts;
    // The leaves found, in no order, with their nets.
    Buffer<Patch> patches;
    Buffer<Leaf> leaves;
    Buffer<PartPlace> places;
    Buffer<Point> nets;
    // A warp's memory: numbers, halves, leaves that are tried.
    Buffer<double> memory;
    Buffer<Half> halves;
    Buffer<HalvedLeaf> tried;
};

struct Sizes {
    uint32_t instances;
    // Room for leaves, their control points; a warp's numbers, halves and tried leaves.
    uint32_t parts, part_points, memory, halves, tried;
};

// Writes the leaf that `piece` is at, where there is room; false where all warps have more than a frame holds.
static __device__ bool emit(Piece &piece, const Buffers &out, const Sizes &sizes, uint32_t visible, uint32_t instance,
                            uint32_t number) {
    const Warp &warp = piece.warp;
    uint32_t part = 0;
    unsigned long long net = 0;
    if (warp.lane == 0) {
        part = atomicAdd(&out.counters[0].parts, 1u);
        net = atomicAdd(counts::word(out.counters[0].part_points), (unsigned long long)piece.net.count());
    }
    part = warp.first(part), net = warp.first(net);
    if (part >= sizes.parts || net + piece.net.count() > sizes.part_points) {
        return part <= MAX_PARTS;
    }
    const leaf::Drawn drawn = {piece.view,       piece.rules,
                               piece.scene,      piece.instance,
                               piece.source,     piece.map,
                               piece.place,      piece.grid,
                               instance,         uint32_t(&piece.source - &piece.scene.patches[0]),
                               {piece.corner[0], piece.corner[1]},
                               {piece.extent[0], piece.extent[1]}};
    leaf::write_net(warp, drawn, piece.net, out.nets + net);
    if (warp.lane == 0) {
        out.patches[part] = leaf::patch_of(drawn, 0);
        out.leaves[part] = leaf::leaf_of(drawn, out.nets + net);
        out.places[part] = {visible, number, uint32_t(net), 0};
    }
    return true;
}

// Finds all leaves of a patch, in the order of parameters; an error, or 0.
static __device__ uint32_t leaves_of(Piece &piece, Lists &lists, const Buffers &out, const Sizes &sizes, uint32_t visible,
                                     uint32_t instance, uint32_t &number) {
    uint32_t kept = 0;
    piece.path = Path::root();
    bool more = true;
    while (more) {
        const Finding found = piece.look();
        if (found == SPLIT_U || found == SPLIT_V || found == WIDE_U || found == WIDE_V) {
            kept += found == WIDE_U || found == WIDE_V;
            piece.path.halve(found == SPLIT_V || found == WIDE_V);
            continue;
        }
        if (found > WIDE_V) {
            return found == TOO_CLOSE ? ERROR_TOO_CLOSE : found == TOO_LARGE ? ERROR_GRID_TOO_LARGE : ERROR_TOLERANCE;
        }
        if (found == DRAWN) {
            if (kept++ == MAX_LEAVES) {
                return ERROR_TOO_MANY_LEAVES;
            }
            const Path here = piece.path;
            const Half whole = piece.half();
            const bool parts = cheaper_halves(piece, lists);
            for (uint32_t k = 0; k < (parts ? lists.length : 1); k++) {
                piece.go_to(parts ? lists.list[k] : whole);
                piece.load();
                cull::judge(piece.warp, piece.view, piece.rules, piece.net, piece.map, piece.path.depth, piece.place);
                // The host says why. What warps count until all have stopped fits 32 bits.
                if (!emit(piece, out, sizes, visible, instance, number++)) {
                    return 0;
                }
            }
            piece.path = here;
        }
        more = piece.path.advance(0);
    }
    // Something was kept, whatever became of it: `Leaves::patches_visible`.
    if (piece.warp.lane == 0 && kept > 0) {
        atomicAdd(&out.counters[0].visible, 1u);
    }
    return 0;
}

} // namespace split

// A warp a block; each takes patches until none is left.
extern "C" __global__ void __launch_bounds__(32, 8)
    split_patches(const __grid_constant__ View view, const __grid_constant__ Rules rules,
                  const __grid_constant__ scene::Scene scene, const __grid_constant__ split::Buffers out,
                  const __grid_constant__ split::Sizes sizes) {
    SHARED(double, numbers, [bounds::NUMBERS]);
    SHARED(bounds::Enclosure, enclosure, [1]);
    const split::Warp warp = split::Warp::here();
    const uint32_t work = out.counters[0].split;
    while (true) {
        uint32_t taken = 0;
        if (warp.lane == 0) {
            taken = atomicAdd(&out.counters[0].taken, 1u);
        }
        taken = warp.first(taken);
        if (taken >= work || warp.first(racy_load(&out.counters[0].parts)) > split::MAX_PARTS) {
            return;
        }
        const uint32_t visible = out.work[taken], item = out.visible[visible].item;
        const uint32_t number = scene::instance_of(scene, sizes.instances, item);
        const SceneInstance &instance = scene.instances[number];
        const ScenePatch &source = scene.patches[instance.first_patch + (item - instance.first_item)];
        const lens::PatchMap map = lens::patch_map(view, instance, load_vector(source.origin));
        split::Piece piece = {view, rules, scene, instance, source, map, warp,
                              out.memory + uint64_t(blockIdx.x) * sizes.memory, numbers, enclosure[0]};
        split::Lists lists = {out.halves + uint64_t(blockIdx.x) * sizes.halves, sizes.halves,
                              out.tried + uint64_t(blockIdx.x) * sizes.tried};
        uint32_t leaves = 0;
        const uint32_t error = split::leaves_of(piece, lists, out, sizes, visible, number, leaves);
        if (warp.lane == 0) {
            out.leaf_counts[visible] = leaves;
            out.point_counts[visible] = leaves * uint32_t(piece.net.count());
            if (error != 0) {
                atomicMin(counts::word(out.counters[0].error), (unsigned long long)item << 8 | error);
            }
            if (lists.full) {
                atomicAdd(&out.counters[0].short_of_halves, 1u);
            }
        }
        warp.sync();
    }
}
KERNEL(split_patches)

// As many leaves as there are, where splitting had room for all it made and met no error, and all control points fit; else more
// than anybody has room for.
extern "C" __global__ void __launch_bounds__(1)
    split_check(Buffer<const Counters> counters, uint32_t parts, uint32_t part_points, Count leaves, Count points,
                Buffer<uint64_t> out) {
    const Counters c = counters[0];
    const bool whole = c.error == NO_ERROR && c.short_of_halves == 0 && c.parts <= parts && c.part_points <= part_points;
    out[0] = whole && leaves.fits() && points.fits() ? leaves.all() : counts::TOO_MANY;
}
KERNEL(split_check)

// A thread a part: to its place among `all` leaves.
extern "C" __global__ void __launch_bounds__(128)
    place_parts(Buffer<const Counters> counters, Count all, Buffer<const PartPlace> places, Buffer<const Patch> part_patches,
                Buffer<const Leaf> part_leaves, Buffer<const Point> part_nets, Buffer<const uint32_t> first_leaves,
                Buffer<const uint32_t> first_points, Buffer<Patch> patches, Buffer<Leaf> leaves, Buffer<Point> nets) {
    const uint32_t part = blockIdx.x * blockDim.x + threadIdx.x;
    if (!all.fits() || part >= counters[0].parts) {
        return;
    }
    const PartPlace place = places[part];
    const uint32_t to = first_leaves[place.visible] + place.number;
    Patch patch = part_patches[part];
    const uint32_t points = (patch.degree[0] + 1u) * (patch.degree[1] + 1u);
    patch.net = first_points[place.visible] + place.number * points;
    for (uint32_t k = 0; k < points; k++) {
        nets[patch.net + k] = part_nets[place.net + k];
    }
    patches[to] = patch;
    leaves[to] = part_leaves[part];
}
KERNEL(place_parts)
