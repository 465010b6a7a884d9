//! Atomics of all threads of the CPU on the same words.

use crate::support::under_all_schedules;
use halfpixel::emulated::{Device, Schedule, Shape};

#[test]
fn contended_words_are_exact() {
    const THREADS: u32 = 64 * 128;
    let (wide, narrow, real) = under_all_schedules(|device| {
        let wide = device.upload(&[0_u64, !0, 0, 0, 0, !0]);
        let narrow = device.upload(&[0_u32, 0, !0, 0, 1 << 20, 0]);
        let real = device.zeroed::<f32>(1);
        let arguments = [&wide.pointer() as _, &narrow.pointer() as _, &real.pointer() as _];
        device.launch("selftest_atomics", Shape::row(THREADS / 128, 128), &arguments).unwrap();
        (device.download(&wide).unwrap(), device.download(&narrow).unwrap(), device.download(&real).unwrap())
    });
    let hash = |i: u32| i.wrapping_mul(2_654_435_761);
    let keys = || (0..THREADS).map(|i| u64::from(hash(i)) << 32 | u64::from(i));
    assert_eq!(wide[0], keys().max().unwrap());
    assert_eq!(wide[1], keys().min().unwrap());
    assert_eq!(wide[2], (0..u64::from(THREADS)).map(|i| i << 33).fold(0, u64::wrapping_add));
    assert_eq!(wide[3], keys().fold(0, |a, b| a ^ b));
    assert_eq!(wide[4], !0);
    assert_eq!(wide[5], !0 << 61);
    assert_eq!(narrow[0], (0..THREADS).sum::<u32>());
    assert_eq!(narrow[1], (0..THREADS).map(hash).max().unwrap());
    assert_eq!(narrow[2], (0..THREADS).map(hash).min().unwrap());
    assert_eq!(narrow[3], THREADS % 100);
    assert_eq!(narrow[4], (1 << 20) - 2 * THREADS);
    assert_eq!(narrow[5], THREADS - 1);
    assert_eq!(real, [THREADS as f32 / 2.0]);
}

/// A visibility buffer under a race of 64-bit maxima.
#[test]
fn the_largest_word_of_a_pixel_wins() {
    const PIXELS: i32 = 50;
    const ROUNDS: i32 = 40;
    const THREADS: u32 = 256 * 64;
    let mut expected = vec![0_u64; PIXELS as usize];
    for i in 0..THREADS {
        for r in 0..ROUNDS as u32 {
            let mut h = i.wrapping_mul(31).wrapping_add(r).wrapping_mul(2_654_435_761);
            h ^= h >> 15;
            let word = u64::from(h.wrapping_mul(2_246_822_519)) << 32 | u64::from(i);
            let pixel = &mut expected[(h % PIXELS as u32) as usize];
            *pixel = word.max(*pixel);
        }
    }
    for threads in [1, 2, 8] {
        let mut device = Device::new(Schedule::default(), threads);
        let words = device.zeroed::<u64>(PIXELS as usize);
        let shape = Shape::row(THREADS / 64, 64);
        device.launch("selftest_visibility", shape, &[&words.pointer(), &PIXELS, &ROUNDS]).unwrap();
        assert_eq!(device.download(&words).unwrap(), expected);
    }
}
