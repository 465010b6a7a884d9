// cull: which patches can be seen, and which of them must be split first. Twin of src/stages/cull.rs.
#include "cone.cuh"
#include "count.cuh"
#include "judge.cuh"

// A thread a patch of an instance; `states` says what becomes of it, `seen` is 1 where it is not culled.
extern "C" __global__ void __launch_bounds__(128)
    cull_patches(const __grid_constant__ View view, const __grid_constant__ Rules rules,
                 const __grid_constant__ scene::Scene scene, uint32_t instances, uint32_t items, Buffer<uint8_t> states,
                 Buffer<uint32_t> seen) {
    const uint32_t item = blockIdx.x * blockDim.x + threadIdx.x;
    if (item >= items) {
        return;
    }
    const SceneInstance &instance = scene.instances[scene::instance_of(scene, instances, item)];
    const ScenePatch &patch = scene.patches[instance.first_patch + (item - instance.first_item)];
    const lens::PatchMap map = lens::patch_map(view, instance, load_vector(patch.origin));
    cull::Verdict verdict = cull::CULLED;
    if (!cone::is_outside(view, patch.radius, map)
        && !cone::is_back_patch(view, patch, scene::visible_side(rules, patch), map)) {
        cull::Place place;
        verdict = cull::judge(Team<1>::here(), view, rules, scene::net_of(scene, patch), map, 0, place);
        const double corner[2] = {0.0, 0.0}, extent[2] = {1.0, 1.0};
        if (verdict != cull::CULLED && cull::trimmed_away(view, scene, patch, corner, extent)) {
            verdict = cull::CULLED;
        }
    }
    const uint32_t state = verdict == cull::CULLED ? ITEM_CULLED : verdict == cull::KEEP ? ITEM_WHOLE : ITEM_SPLIT;
    states[item] = uint8_t(state);
    seen[item] = state != ITEM_CULLED;
}
KERNEL(cull_patches)

// A thread a patch of an instance: those that are not culled, in order. `slots`: the exclusive sums of `seen`.
extern "C" __global__ void __launch_bounds__(256)
    cull_compact(uint32_t items, Buffer<const uint8_t> states, Buffer<const uint32_t> slots, Count seen,
                 Buffer<Visible> visible) {
    const uint32_t item = blockIdx.x * blockDim.x + threadIdx.x;
    if (item < items && seen.fits() && states[item] != ITEM_CULLED) {
        visible[slots[item]] = {item, states[item], {0, 0}, 0, {0.0f, 0.0f}};
    }
}
KERNEL(cull_compact)
