// A part of a patch, found anew by its halvings: a warp looks at one after the other, without recursion.
#pragma once
#include "enclosure.cuh"
#include "leaf.cuh"

namespace split {

using enclosure::Warp;

// The halvings that lead from a patch to a part of it.
struct Path {
    uint64_t axes[2], sides[2];
    uint32_t depth;

    static __device__ __forceinline__ Path root() { return {{0, 0}, {0, 0}, 0}; }

    __device__ __forceinline__ int axis(uint32_t level) const { return (level < 64 ? axes[0] : axes[1]) >> level % 64 & 1; }
    __device__ __forceinline__ int side(uint32_t level) const { return (level < 64 ? sides[0] : sides[1]) >> level % 64 & 1; }

    // On to the lower half.
    __device__ __forceinline__ void halve(int axis) {
        const uint64_t bit = 1ull << depth % 64;
        if (depth < 64) {
            axes[0] = axis ? axes[0] | bit : axes[0] & ~bit;
            sides[0] &= ~bit;
        } else {
            axes[1] = axis ? axes[1] | bit : axes[1] & ~bit;
            sides[1] &= ~bit;
        }
        depth++;
    }

    // On to the next part, in the order of parameters; false where all within the first `base` halvings have been seen.
    __device__ __forceinline__ bool advance(uint32_t base) {
        while (depth > base && side(depth - 1)) {
            depth--;
        }
        if (depth == base) {
            return false;
        }
        const uint32_t level = depth - 1;
        if (level < 64) {
            sides[0] |= 1ull << level;
        } else {
            sides[1] |= 1ull << level % 64;
        }
        return true;
    }
};

// What is found of a part.
enum Finding {
    GONE,
    DRAWN,
    // To be halved across u, or across v: by culling, and because its grid would be too large.
    SPLIT_U,
    SPLIT_V,
    WIDE_U,
    WIDE_V,
    TOO_CLOSE,
    TOO_LARGE,
    NO_TOLERANCE,
};

// Part of a patch of an instance. The warp's memory: two nets, and what enclosing one takes.
struct Piece {
    const View &view;
    const Rules &rules;
    const scene::Scene &scene;
    const SceneInstance &instance;
    const ScenePatch &source;
    const lens::PatchMap map;
    const Warp warp;
    Buffer<double> memory;
    Span<double> numbers;
    bounds::Enclosure &enclosure;

    Path path = {};
    lens::Net net = {};
    double corner[2] = {}, extent[2] = {};
    cull::Place place = {};
    estimate::Grid grid = {};

    // Makes the net at the end of the path: the CPU's own halvings, one after the other.
    __device__ void load() {
        net = scene::net_of(scene, source);
        corner[0] = corner[1] = 0.0;
        extent[0] = extent[1] = 1.0;
        if (path.depth == 0) {
            return;
        }
        const int count = net.count();
        Buffer<ControlPoint> own = as<ControlPoint>(memory), other = own + count;
        warp.sync();
        for (int k = warp.lane; k < count; k += 32) {
            own[k] = net.points[k];
        }
        warp.sync();
        for (uint32_t level = 0; level < path.depth; level++) {
            const int axis = path.axis(level);
            enclosure::halve(warp, own, other, net.degree_u, net.degree_v, axis);
            double &size = axis ? extent[1] : extent[0];
            size *= 0.5;
            if (path.side(level)) {
                (axis ? corner[1] : corner[0]) += size;
            } else {
                const Buffer<ControlPoint> low = other;
                other = own;
                own = low;
            }
        }
        net.points = own;
    }

    // Where it is, whether it is drawn, and with which grid. A function of its own: this is much code for three callers.
    __device__ __noinline__ Finding look() {
        load();
        const cull::Verdict verdict = cull::judge(warp, view, rules, net, map, path.depth, place);
        if (verdict == cull::CULLED || cull::trimmed_away(view, scene, source, corner, extent)) {
            return GONE;
        }
        if (verdict == cull::TOO_CLOSE) {
            return TOO_CLOSE;
        }
        if (verdict == cull::SPLIT) {
            return cull::longer_axis(warp, view, net, map) ? SPLIT_V : SPLIT_U;
        }
        enclose();
        const bool small = rules.grid == GRID_ETER16;
        switch (estimate::grid_of(warp, view, rules, rules.bound, small, map, net, enclosure, place, path.depth, numbers, 1,
                                  grid)) {
        case estimate::GRID: return DRAWN;
        case estimate::SPLIT_U: return WIDE_U;
        case estimate::SPLIT_V: return WIDE_V;
        case estimate::TOO_LARGE: return TOO_LARGE;
        default: return NO_TOLERANCE;
        }
    }

    // The second derivatives, where the bound looks at them.
    __device__ void enclose() {
        if (rules.bound != BOUND_SCREEN && rules.bound != BOUND_FILIP) {
            return;
        }
        warp.sync();
        if (path.depth > 0) {
            enclosure::of_net(warp, net, {memory + 8 * net.count()}, enclosure);
        } else if (warp.lane == 0) {
            enclosure = bounds::enclosure_of(source);
        }
        warp.sync();
    }

    __device__ __forceinline__ Half half() const {
        return {{path.axes[0], path.axes[1]},       {path.sides[0], path.sides[1]},           path.depth, grid.diagonal,
                {grid.quads[0], grid.quads[1]}, {grid.deviation[0], grid.deviation[1]}};
    }

    __device__ __forceinline__ void go_to(const Half &half) {
        path = {{half.axes[0], half.axes[1]}, {half.sides[0], half.sides[1]}, half.depth};
        grid = {{half.quads[0], half.quads[1]}, half.diagonal, {half.deviation[0], half.deviation[1]}};
    }
};

} // namespace split
