//! Barriers, shared memory, orders.

use crate::support::under_all_schedules;
use halfpixel::emulated::{BlockOrder, Device, LaneOrder, Schedule, Shape, WarpOrder};
use std::collections::HashSet;

#[test]
fn barriers_and_their_votes() {
    const BLOCKS: usize = 9;
    let input: Vec<i32> = (0..256 * BLOCKS as i32).map(|i| i * 7919 % 1000 - 300).collect();
    let (sums, votes) = under_all_schedules(|device| {
        let inputs = device.upload(&input);
        let [sums, votes] = [(); 2].map(|()| device.allocate::<i32>(BLOCKS));
        let arguments = [&inputs.pointer() as _, &sums.pointer() as _, &votes.pointer() as _];
        device.launch("selftest_block", Shape::row(BLOCKS as u32, 256), &arguments).unwrap();
        (device.download(&sums).unwrap(), device.download(&votes).unwrap())
    });
    let expected: Vec<i32> = input.chunks(256).map(|block| block.iter().sum()).collect();
    assert_eq!(sums, expected);
    assert!(votes.iter().all(|&v| v == 86 | 1 << 16 | 1 << 18), "{votes:?}");
}

#[test]
fn dynamic_memory_of_the_size_asked_for() {
    for n in [32_i32, 100, 1024] {
        let found = under_all_schedules(|device| {
            let out = device.allocate::<i32>(2 * n as usize);
            let shape = Shape::row(2, n as u32).with_dynamic(4 * n as u32);
            device.launch("selftest_dynamic", shape, &[&out.pointer(), &n]).unwrap();
            device.download(&out).unwrap()
        });
        let expected: Vec<i32> = (0..n).rev().chain((0..n).rev()).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn shapes_of_shared_variables_and_threads_that_leave() {
    let found = under_all_schedules(|device| {
        let out = device.allocate::<i32>(16);
        device.launch("selftest_shapes", Shape::row(1, 32), &[&out.pointer()]).unwrap();
        device.download(&out).unwrap()
    });
    let sum: i32 = (0..32).sum();
    let expected: Vec<i32> = (0..16).map(|t| sum + 10 * (t & 1) + 1).collect();
    assert_eq!(found, expected);
}

/// Blocks that follow each other on one thread of the CPU use the same memory; none may see what another left.
#[test]
fn shared_memory_starts_as_poison() {
    let found = under_all_schedules(|device| {
        let out = device.zeroed::<u32>(8 * 64);
        device.launch("selftest_poison", Shape::row(8, 32).with_dynamic(128), &[&out.pointer()]).unwrap();
        device.download(&out).unwrap()
    });
    assert!(found.iter().all(|&word| word == !0), "{found:x?}");
}

#[test]
fn memory_of_the_device_starts_as_poison() {
    let mut device = Device::default();
    let fresh = device.allocate::<f32>(5);
    assert!(device.download(&fresh).unwrap().iter().all(|x| x.is_nan()));
    device.free(&fresh).unwrap();
    assert!(device.download(&fresh).unwrap_err().to_string().contains("freed"));
}

/// Tickets that two warps of two blocks draw, before and after a __syncwarp.
fn tickets(schedule: Schedule) -> Vec<u32> {
    let mut device = Device::new(schedule, 1);
    let (ticket, out) = (device.zeroed::<u32>(1), device.allocate::<u32>(2 * 128));
    device.launch("selftest_order", Shape::row(2, 64), &[&ticket.pointer(), &out.pointer()]).unwrap();
    device.download(&out).unwrap()
}

#[test]
fn orders_do_what_they_say() {
    let of = |lanes, warps, blocks| tickets(Schedule { lanes, warps, blocks, ..Schedule::default() });
    use {BlockOrder as B, LaneOrder as L, WarpOrder as W};
    let first = |found: &[u32], thread: usize| found[2 * thread];
    let second = |found: &[u32], thread: usize| found[2 * thread + 1];
    let plain = of(L::Forward, W::FirstAhead, B::Forward);
    assert_eq!([first(&plain, 0), first(&plain, 1), second(&plain, 0), first(&plain, 32)], [0, 1, 32, 64]);
    let reverse = of(L::Reverse, W::FirstAhead, B::Forward);
    assert_eq!([first(&reverse, 31), first(&reverse, 0), second(&reverse, 31)], [0, 31, 32]);
    let last = of(L::Forward, W::LastAhead, B::Reverse);
    assert_eq!([first(&last, 96), second(&last, 96), first(&last, 64), first(&last, 32)], [0, 32, 64, 128]);
    let turns = of(L::Forward, W::Turns, B::Forward);
    assert_eq!([first(&turns, 0), first(&turns, 32), first(&turns, 1)], [0, 1, 2]);
    let random: HashSet<Vec<u32>> = (0..8)
        .map(|seed| {
            tickets(Schedule { lanes: L::Random, warps: W::Random, blocks: B::Random, seed, ..Schedule::default() })
        })
        .collect();
    assert_eq!(random.len(), 8, "each seed is another order");
}

#[test]
fn a_thread_may_wait_for_another_in_a_loop() {
    let found = under_all_schedules(|device| {
        let out = device.allocate::<u32>(96);
        device.launch("selftest_spin", Shape::row(1, 96), &[&out.pointer()]).unwrap();
        device.download(&out).unwrap()
    });
    assert!(found.iter().all(|&word| word == 5));
}
