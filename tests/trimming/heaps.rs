//! Pictures of heaps of small solids against the oracle.

use super::support::heap::judged;
use halfpixel::scene::View;

/// Solids, their size, the seed.
const HEAPS: [(usize, f64, u64); 3] = [(30_000, 2.5, 1), (30_000, 2.5, 4), (60_000, 1.2, 3)];

/// Where triangles of a fillet show the inside of its solid, its surface may still face the eye: without what they propose
/// some pixels showed what lies behind. Of what is shown instead of the nearest surface, one in 100,000 may be hidden.
#[test]
fn every_pixel_of_a_heap_shows_what_is_in_front() {
    let (mut pixels, mut covering) = (0, 0);
    for (count, size, seed) in HEAPS {
        for (view, orthographic) in [(View::Top, false), (View::Top, true), (View::Iso, false)] {
            let report = judged(count, size, seed, view, orthographic);
            let wrong = [report.violations, report.cracks, report.depth_failures];
            assert_eq!(wrong, [0; 3], "{count} {size} {seed} {view:?}: {:?}", report.worst);
            pixels += report.pixels;
            covering += report.covering_failures;
        }
    }
    assert!(covering <= pixels / 100_000, "{covering} of {pixels} pixels show what is hidden");
}
