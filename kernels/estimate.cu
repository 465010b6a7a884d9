// estimate: the grid of every visible patch, and what the later stages know of it. Twin of src/stages/estimate.rs.
#include "count.cuh"
#include "leaf.cuh"

namespace estimate {

constexpr uint32_t THREADS = 64;

// The patch of an instance that a thread looks at.
struct Subject {
    uint32_t number, source_number;
    const SceneInstance &instance;
    const ScenePatch &source;
    lens::PatchMap map;
    lens::Net net;

    __device__ __forceinline__ Subject(const View &view, const scene::Scene &scene, uint32_t instances, uint32_t item)
        : number(scene::instance_of(scene, instances, item)),
          source_number(scene.instances[number].first_patch + (item - scene.instances[number].first_item)),
          instance(scene.instances[number]), source(scene.patches[source_number]),
          map(lens::patch_map(view, instance, load_vector(source.origin))), net(scene::net_of(scene, source)) {}
};

// A thread a visible patch: its grid, or its number in `work`, if it is not to be drawn as a whole.
static __device__ __forceinline__ void patches(const View &view, const Rules &rules, uint32_t bound, bool small,
                                               const scene::Scene &scene, uint32_t instances, const Count &count, Buffer<Visible> visible,
                                               Buffer<uint32_t> leaf_counts, Buffer<uint32_t> point_counts,
                                               Buffer<uint32_t> work, Buffer<Counters> counters) {
    SHARED(double, numbers, [bounds::NUMBERS * estimate::THREADS]);
    const uint32_t k = blockIdx.x * estimate::THREADS + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const Visible here = visible[k];
    const estimate::Subject s(view, scene, instances, here.item);
    const Team<1> team = Team<1>::here();
    bool whole = here.state == ITEM_WHOLE;
    if (whole) {
        cull::Place place;
        cull::judge(team, view, rules, s.net, s.map, 0, place);
        estimate::Grid grid = {};
        const estimate::Outcome outcome =
            estimate::grid_of(team, view, rules, bound, small, s.map, s.net, bounds::enclosure_of(s.source), place, 0,
                              numbers + threadIdx.x, estimate::THREADS, grid);
        const uint32_t points = uint32_t(s.net.count());
        whole = outcome == estimate::GRID
                && (rules.grid != GRID_ADAPTIVE
                    || grid.all_quads() < estimate::worth_halving(points, s.source.rational != 0));
        if (whole) {
            visible[k] = {here.item,
                          ITEM_WHOLE,
                          {uint16_t(grid.quads[0]), uint16_t(grid.quads[1])},
                          grid.diagonal,
                          {grid.deviation[0], grid.deviation[1]}};
            leaf_counts[k] = 1;
            point_counts[k] = points;
        }
    }
    if (!whole) {
        visible[k].state = ITEM_SPLIT;
        work[atomicAdd(&counters[0].split, 1u)] = k;
    }
}

} // namespace estimate

// Before anything is counted.
extern "C" __global__ void __launch_bounds__(1) estimate_begin(Buffer<Counters> counters) {
    Counters begin = {};
    begin.error = NO_ERROR;
    counters[0] = begin;
}
KERNEL(estimate_begin)

// BOUND: a `BoundRule` that the compiler knows, or that of the rules; SMALL: whether triangles are kept small. BLOCKS: that a
// multiprocessor holds without spills.
#define ESTIMATE(name, BOUND, SMALL, BLOCKS)                                                                           \
    extern "C" __global__ void __launch_bounds__(estimate::THREADS, BLOCKS)                                            \
        name(const __grid_constant__ View view, const __grid_constant__ Rules rules,                                   \
             const __grid_constant__ scene::Scene scene, uint32_t instances, Count count, Buffer<Visible> visible,     \
             Buffer<uint32_t> leaf_counts, Buffer<uint32_t> point_counts, Buffer<uint32_t> work,                       \
             Buffer<Counters> counters) {                                                                              \
        estimate::patches(view, rules, BOUND, SMALL, scene, instances, count, visible, leaf_counts, point_counts, work,  \
                          counters);                                                                                   \
    }                                                                                                                  \
    KERNEL(name)

ESTIMATE(estimate_patches, rules.bound, rules.grid == GRID_ETER16, 4)
// The default bound: much less code.
ESTIMATE(estimate_patches_screen, BOUND_SCREEN, false, 6)

// A thread a visible patch that is drawn as a whole: its leaf, in its place among `all`.
extern "C" __global__ void __launch_bounds__(128)
    estimate_leaves(const __grid_constant__ View view, const __grid_constant__ Rules rules,
                    const __grid_constant__ scene::Scene scene, uint32_t instances, Count count,
                    Buffer<const Visible> visible, Buffer<const uint32_t> first_leaves, Buffer<const uint32_t> first_points, Count all,
                    Buffer<Patch> patches, Buffer<Leaf> leaves, Buffer<Point> nets) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get() || !all.fits() || visible[k].state != ITEM_WHOLE) {
        return;
    }
    const Visible here = visible[k];
    const estimate::Subject s(view, scene, instances, here.item);
    const Team<1> team = Team<1>::here();
    cull::Place place;
    cull::judge(team, view, rules, s.net, s.map, 0, place);
    const estimate::Grid grid = {{here.quads[0], here.quads[1]}, here.diagonal, {here.deviation[0], here.deviation[1]}};
    const leaf::Drawn drawn = {view,  rules, scene,    s.instance,      s.source,   s.map,
                               place, grid,     s.number, s.source_number, {0.0, 0.0}, {1.0, 1.0}};
    const Buffer<Point> net = nets + first_points[k];
    leaf::write_net(team, drawn, s.net, net);
    patches[first_leaves[k]] = leaf::patch_of(drawn, first_points[k]);
    leaves[first_leaves[k]] = leaf::leaf_of(drawn, net);
}
KERNEL(estimate_leaves)
