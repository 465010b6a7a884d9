// Large leaves in parts, where their own bounds ask for clearly fewer quads: `cheaper_halves` in src/stages/estimate.rs, as a
// machine with a stack of leaves that are tried, and one list of their halves and parts.
#pragma once
#include "piece.cuh"

namespace split {

// The memory of one warp. The list: the halves of a leaf, the parts found for them, the halves of the next leaf, and so on.
struct Lists {
    Buffer<Half> list;
    uint32_t room;
    // Leaves that are tried at once: each is a halving deeper than the one before.
    Buffer<HalvedLeaf> leaves;

    uint32_t length = 0;
    uint32_t tried = 0;
    bool full = false;

    __device__ __forceinline__ bool push(const Warp &warp, const Half &half) {
        if (length == room) {
            full = true;
            return false;
        }
        if (warp.lane == 0) {
            list[length] = half;
        }
        length++;
        warp.sync();
        return true;
    }
};

static __device__ __forceinline__ bool fewer(uint32_t quads, uint32_t than) {
    return double(quads) <= double(than) * estimate::HALVES_KEPT;
}

// Starts to try the halves of the leaf that `piece` is at; false where that is of no use.
static __device__ bool try_halves(Piece &piece, Lists &lists, uint32_t tries) {
    const uint32_t quads = piece.grid.all_quads(), base = piece.path.depth;
    const uint32_t points = uint32_t(piece.net.count());
    if (piece.rules.grid != GRID_ADAPTIVE || base >= estimate::MAX_DEPTH
        || quads < estimate::worth_halving(points, piece.source.rational != 0)) {
        return false;
    }
    const uint32_t first = lists.length;
    uint32_t sum = 0;
    piece.path.halve(piece.grid.quads[1] > piece.grid.quads[0]);
    bool good = true, more = true;
    while (good && more) {
        const Finding found = piece.look();
        if (found == SPLIT_U || found == SPLIT_V) {
            piece.path.halve(found == SPLIT_V);
            continue;
        }
        // What can't be had, or would be too large, is no gain.
        good = found == GONE || found == DRAWN;
        if (found == DRAWN) {
            sum += piece.grid.all_quads();
            good = lists.push(piece.warp, piece.half());
        }
        more = piece.path.advance(base);
    }
    const bool gained = fewer(sum, quads);
    if (!good || (!gained && tries == 0)) {
        lists.length = first;
        return false;
    }
    if (piece.warp.lane == 0) {
        lists.leaves[lists.tried] = {first, first, lists.length, gained ? estimate::LOOK_AHEAD : tries - 1, quads, 0};
    }
    lists.tried++;
    piece.warp.sync();
    return true;
}

// Tries to draw the leaf that `piece` is at in parts. True: they are the list.
static __device__ bool cheaper_halves(Piece &piece, Lists &lists) {
    const Warp &warp = piece.warp;
    lists.length = lists.tried = 0;
    if (!try_halves(piece, lists, estimate::LOOK_AHEAD)) {
        return false;
    }
    while (true) {
        HalvedLeaf leaf = lists.leaves[lists.tried - 1];
        warp.sync();
        bool done = leaf.next == leaf.end, failed = !fewer(leaf.part_quads, leaf.quads);
        if (!done && !failed) {
            const Half half = lists.list[leaf.next++];
            if (warp.lane == 0) {
                lists.leaves[lists.tried - 1].next = leaf.next;
            }
            warp.sync();
            piece.go_to(half);
            if (try_halves(piece, lists, leaf.tries)) {
                continue;
            }
            leaf.part_quads += half.quads[0] * half.quads[1];
            failed = !lists.push(warp, half);
        }
        if (lists.full) {
            return false;
        }
        uint32_t gained = leaf.part_quads;
        if (failed || done) {
            lists.tried--;
            // Parts take the place of the halves; a leaf that has none stands itself.
            const uint32_t parts = failed ? 0 : lists.length - leaf.end;
            for (uint32_t k = 0; warp.lane == 0 && k < parts; k++) {
                lists.list[leaf.first + k] = lists.list[leaf.end + k];
            }
            warp.sync();
            lists.length = leaf.first + parts;
            if (lists.tried == 0) {
                return !failed;
            }
            leaf = lists.leaves[lists.tried - 1];
            warp.sync();
            if (failed) {
                const Half half = lists.list[leaf.next - 1];
                gained = half.quads[0] * half.quads[1];
                if (!lists.push(warp, half)) {
                    return false;
                }
            }
            leaf.part_quads += gained;
        }
        if (warp.lane == 0) {
            lists.leaves[lists.tried - 1].part_quads = leaf.part_quads;
        }
        warp.sync();
    }
}

} // namespace split
