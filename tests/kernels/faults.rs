//! Every mistake that is diagnosed, with the line it is in.

use crate::support::fault;
use halfpixel::emulated::{Buffer, Device, Fault, FaultKind, LaunchError, Schedule, Shape};

const FILE: &str = "kernels/host/selftest/faults.cu";

/// The line of `// MARK name`.
fn marked(name: &str) -> u32 {
    let text = include_str!("../../kernels/host/selftest/faults.cu");
    let has = |line: &str| line.split("// MARK ").nth(1).is_some_and(|mark| mark.trim() == name);
    text.lines().position(has).unwrap_or_else(|| panic!("no mark {name}")) as u32 + 1
}

/// A launch with one buffer, under all schedules; the fault of the first one.
fn provoke(kernel: &str, shape: Shape, mark: &str, kind: FaultKind) -> Fault {
    provoke_with(kernel, shape, mark, kind, |device, out| device.launch(kernel, shape, &[&out.pointer()]))
}

fn provoke_with(
    kernel: &str,
    shape: Shape,
    mark: &str,
    kind: FaultKind,
    launch: impl Fn(&mut Device, &Buffer<u32>) -> Result<(), LaunchError>,
) -> Fault {
    let mut faults = Schedule::adversarial().into_iter().map(|schedule| {
        let mut device = Device::new(schedule, 2);
        let out = device.zeroed::<u32>(64 * shape.grid[0] as usize);
        let found = fault(launch(&mut device, &out));
        let shown = format!("{found} ({:?})", found.kind);
        assert_eq!(found.kind, kind, "{shown}");
        assert_eq!(found.kernel, kernel, "{shown}");
        assert!(!mark.is_empty() || found.file.is_empty(), "{shown}");
        if !mark.is_empty() && kind != FaultKind::Mismatch && kind != FaultKind::Deadlock {
            assert_eq!((found.file.as_str(), found.line), (FILE, marked(mark)), "{shown}");
            assert!(shown.contains(&format!("{FILE}:{}", marked(mark))), "{shown}");
        }
        // The device is as good as before.
        device.launch("selftest_threads", shape, &[&out.pointer()]).unwrap();
        found
    });
    let first = faults.next().unwrap();
    assert!(faults.count() > 0);
    first
}

/// Both lines of a mismatch or deadlock are named; which one comes first depends on the order of threads.
fn assert_names(fault: &Fault, marks: &[&str]) {
    let shown = fault.to_string();
    for mark in marks {
        let place = format!("{FILE}:{}", marked(mark));
        assert!(shown.contains(&place), "{place} is not in: {shown}");
    }
}

#[test]
fn a_lane_outside_its_own_mask() {
    let found = provoke("fault_not_in_mask", Shape::row(1, 32), "not_in_mask", FaultKind::NotInMask);
    assert!(found.message.contains("lane 16 calls __ballot_sync with mask 0000ffff"), "{found}");
    assert_eq!(found.thread, [16, 0, 0]);
}

#[test]
fn different_collectives() {
    let found = provoke("fault_mismatch", Shape::row(1, 32), "mismatch", FaultKind::Mismatch);
    assert_names(&found, &["mismatch", "mismatch_others"]);
    assert!(found.message.contains("__any_sync") && found.message.contains("__ballot_sync"), "{found}");
    let found = provoke("fault_one_line", Shape::row(1, 32), "one_line", FaultKind::Mismatch);
    assert_names(&found, &["one_line"]);
}

#[test]
fn masks_that_disagree() {
    let found = provoke("fault_masks_disagree", Shape::row(1, 32), "masks_disagree", FaultKind::Deadlock);
    assert_names(&found, &["masks_disagree"]);
    assert!(found.message.contains("the masks disagree"), "{found}");
}

#[test]
fn deadlock_between_warp_and_block() {
    let found = provoke("fault_deadlock", Shape::row(4, 32), "deadlock", FaultKind::Deadlock);
    assert_names(&found, &["deadlock", "deadlock_barrier"]);
    assert!(found.message.contains("32 threads wait and none can run"), "{found}");
}

#[test]
fn different_barriers() {
    let found = provoke("fault_barriers", Shape::row(1, 64), "barriers", FaultKind::Mismatch);
    assert_names(&found, &["barriers", "barriers_others"]);
}

#[test]
fn shuffles_from_lanes_that_are_not_there() {
    let found = provoke("fault_returned_lane", Shape::row(1, 32), "returned_lane", FaultKind::SourceLane);
    assert!(found.message.contains("lane 29 reads lane 30, which has returned"), "{found}");
    let found = provoke("fault_source_lane", Shape::row(1, 32), "source_lane", FaultKind::SourceLane);
    assert!(found.message.contains("lane 0 reads lane 8, which takes no part"), "{found}");
    // A block of 20 threads: the other twelve lanes do not exist.
    let found = provoke("fault_returned_lane", Shape::row(1, 20), "returned_lane", FaultKind::SourceLane);
    assert!(found.message.contains("lane 19 reads lane 20, which does not exist"), "{found}");
}

#[test]
fn a_matrix_product_needs_the_whole_warp() {
    let found = provoke("fault_incomplete_warp", Shape::row(1, 32), "incomplete_warp", FaultKind::IncompleteWarp);
    assert!(found.message.contains("mask 7fffffff"), "{found}");
}

#[test]
fn indices_outside_buffers() {
    let shape = Shape::row(1, 8);
    for (offset, element) in [(4, "element 8"), (-8, "element -8"), (1 << 30, "element 1073741824")] {
        let launch = |device: &mut Device, out: &Buffer<u32>| {
            // Neighbours in memory must not hide the mistake.
            let [_, middle, _] = [(); 3].map(|()| device.zeroed::<f32>(8));
            device.launch("fault_buffer", shape, &[&middle.pointer(), &out.pointer(), &offset])
        };
        let found = provoke_with("fault_buffer", shape, "buffer", FaultKind::OutOfBounds, launch);
        assert!(found.message.contains(element) && found.message.contains("has 8 elements of 4 bytes"), "{found}");
    }
    let launch = |device: &mut Device, out: &Buffer<u32>| {
        device.launch("fault_atomic", shape, &[&out.pointer(), &(out.len() as u32)])
    };
    provoke_with("fault_atomic", shape, "atomic", FaultKind::OutOfBounds, launch);
}

#[test]
fn a_freed_buffer_and_a_misaligned_one() {
    let shape = Shape::row(1, 8);
    let launch = |device: &mut Device, out: &Buffer<u32>| {
        let gone = device.zeroed::<f32>(8);
        device.free(&gone).unwrap();
        device.launch("fault_buffer", shape, &[&gone.pointer(), &out.pointer(), &0])
    };
    let found = provoke_with("fault_buffer", shape, "buffer", FaultKind::OutOfBounds, launch);
    assert!(found.message.contains("gone"), "{found}");
    let launch = |device: &mut Device, out: &Buffer<u32>| {
        let numbers = device.zeroed::<f32>(8);
        device.launch("fault_misaligned", shape, &[&numbers.pointer(), &out.pointer()])
    };
    let found = provoke_with("fault_misaligned", shape, "misaligned", FaultKind::Misaligned, launch);
    assert!(found.message.contains("not aligned to 16 bytes"), "{found}");
}

#[test]
fn indices_outside_shared_memory() {
    let at = |kernel: &'static str, mark, shape, i: i32| {
        let launch = |device: &mut Device, out: &Buffer<u32>| device.launch(kernel, shape, &[&out.pointer(), &i]);
        provoke_with(kernel, shape, mark, FaultKind::OutOfBounds, launch)
    };
    let found = at("fault_shared", "shared", Shape::row(1, 64), 64);
    assert!(found.message.contains("element 64 of shared memory that has 64 elements"), "{found}");
    at("fault_shared", "shared", Shape::row(1, 64), -1);
    at("fault_shared_row", "shared_row", Shape::row(1, 1), 8);
    at("fault_dynamic", "dynamic", Shape::row(1, 1).with_dynamic(16), 4);
}

#[test]
fn more_shared_memory_than_there_is() {
    let found = provoke("fault_too_much_shared", Shape::row(1, 32), "too_much_shared", FaultKind::SharedMemory);
    assert!(found.message.contains("52000 bytes"), "{found}");
}

#[test]
fn launches_that_are_refused() {
    let mut device = Device::default();
    let out = device.zeroed::<u32>(64);
    let mut launch = |kernel: &str, shape, arguments: &[&dyn halfpixel::emulated::Argument]| {
        device.launch(kernel, shape, arguments).unwrap_err()
    };
    let pointer = out.pointer();
    let error = launch("no_such_kernel", Shape::row(1, 1), &[]);
    assert_eq!(error, LaunchError::UnknownKernel("no_such_kernel".into()));
    let error = launch("selftest_threads", Shape::row(1, 1), &[]);
    assert!(matches!(error, LaunchError::ArgumentCount { expected: 1, given: 0, .. }), "{error}");
    let error = launch("selftest_threads", Shape::row(1, 1), &[&1_u32]);
    assert!(matches!(error, LaunchError::ArgumentSize { index: 0, expected: 8, given: 4, .. }), "{error}");
    let error = launch("sanitize_warp", Shape::row(1, 64), &[&pointer]);
    assert!(matches!(error, LaunchError::PlainPointer { index: 0, .. }), "{error}");
    for shape in [Shape::row(0, 32), Shape::row(1, 0), Shape::row(1, 1025), Shape::row(1, 32).with_dynamic(1 << 18)] {
        let found = fault(Err(launch("selftest_threads", shape, &[&pointer])));
        assert_eq!(found.kind, FaultKind::BadLaunch, "{found}");
    }
}

/// Launches of several devices at once, some of which fail.
#[test]
fn devices_share_nothing() {
    std::thread::scope(|scope| {
        for worker in 0..4_u32 {
            scope.spawn(move || {
                for round in 0..20 {
                    let schedule = Schedule::adversarial()[round % 9];
                    let mut device = Device::new(schedule, 2);
                    let out = device.zeroed::<u32>(256);
                    if worker % 2 == 0 {
                        let result = device.launch("fault_not_in_mask", Shape::row(4, 64), &[&out.pointer()]);
                        assert_eq!(fault(result).kind, FaultKind::NotInMask);
                        continue;
                    }
                    device.launch("selftest_shuffles", Shape::row(4, 64), &[&out.pointer(), &3]).unwrap();
                    assert!(
                        device.download(&out).unwrap().iter().enumerate().all(|(i, &v)| v as usize == (i % 64) ^ 1)
                    );
                }
            });
        }
    });
}
