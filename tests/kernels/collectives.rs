//! Shuffles, votes, matches and reductions against plain loops.

use crate::support::{Random, under_all_schedules};
use halfpixel::emulated::Shape;

const WORDS: usize = 32;
const BLOCKS: u32 = 3;
const THREADS: u32 = 64;

#[test]
fn every_collective_of_a_warp() {
    let mut random = Random(7);
    let mut input: Vec<u32> = (0..BLOCKS * THREADS).map(|_| random.next() as u32).collect();
    // Few distinct values as well, so that matches and extremes have ties.
    input.iter_mut().skip(64).step_by(3).for_each(|v| *v %= 4);
    let output = under_all_schedules(|device| {
        let (inputs, outputs) = (device.upload(&input), device.zeroed::<u32>(input.len() * WORDS));
        let arguments = [&inputs.pointer() as _, &outputs.pointer() as _];
        device.launch("selftest_warp", Shape::row(BLOCKS, THREADS), &arguments).unwrap();
        device.download(&outputs).unwrap()
    });
    for (warp, values) in input.chunks(32).enumerate() {
        let values: &[u32; 32] = values.try_into().unwrap();
        for lane in 0..32 {
            let at = (warp * 32 + lane) * WORDS;
            check_shuffles(values, lane, &output[at..]);
            check_votes(values, lane, &output[at..]);
            check_reductions(values, &output[at..]);
            check_parts(lane, &output[at..]);
        }
    }
}

fn check_shuffles(v: &[u32; 32], lane: usize, found: &[u32]) {
    assert_eq!(found[0], v[5]);
    assert_eq!(found[1], v[lane / 8 * 8 + (lane + 3) % 8]);
    assert_eq!(found[2], if lane < 3 { v[lane] } else { v[lane - 3] });
    assert_eq!(found[3], if lane % 4 < 2 { v[lane] } else { v[lane - 2] });
    assert_eq!(found[4], if lane + 4 > 31 { v[lane] } else { v[lane + 4] });
    assert_eq!(found[5], if lane % 16 == 15 { v[lane] } else { v[lane + 1] });
    assert_eq!(found[6], v[lane ^ 17]);
    assert_eq!(found[7], v[lane ^ 4]);
    assert_eq!(found[22], v[lane ^ 1]);
    assert_eq!(f32::from_bits(found[23]), (30 - lane / 2) as f32 + 0.5);
    assert_eq!(found[26], 11);
}

fn check_votes(v: &[u32; 32], lane: usize, found: &[u32]) {
    let lanes_with = |test: &dyn Fn(u32) -> bool| {
        v.iter().enumerate().filter(|&(_, &x)| test(x)).map(|(i, _)| 1_u32 << i).sum::<u32>()
    };
    assert_eq!(found[8], lanes_with(&|x| x % 2 == 1));
    assert_eq!(found[9], u32::from(v.iter().any(|&x| x > 4_000_000_000)) | 2);
    assert_eq!(found[10], 2);
    assert_eq!(found[11], lanes_with(&|x| x % 5 == v[lane] % 5));
    assert_eq!(found[12], !0 ^ 1, "all match");
    assert_eq!(found[13], 0, "none match");
}

fn check_reductions(v: &[u32; 32], found: &[u32]) {
    let signed = || v.iter().map(|&x| x as i32);
    assert_eq!(found[14], v.iter().fold(0_u32, |a, &b| a.wrapping_add(b)));
    assert_eq!(Some(found[15]), v.iter().copied().min());
    assert_eq!(Some(found[16]), v.iter().copied().max());
    assert_eq!(Some(found[17] as i32), signed().min());
    assert_eq!(Some(found[18] as i32), signed().max());
    assert_eq!(found[19], v.iter().fold(!0, |a, b| a & b));
    assert_eq!(found[20], v.iter().fold(0, |a, b| a | b));
    assert_eq!(found[21], v.iter().fold(0, |a, b| a ^ b));
}

/// Collectives of parts of a warp, and of lanes that are left.
fn check_parts(lane: usize, found: &[u32]) {
    assert_eq!(found[24], if lane < 16 { 0xffff } else { 20 });
    assert_eq!(found[25], 1 << lane);
    let stays = lane.is_multiple_of(2);
    assert_eq!(found[27], if stays { 0x5555_5555 } else { 0 });
    assert_eq!(found[28], if stays { 0x5555_5545 } else { 0 });
}
