//! mma.sp against a plain matrix product.

use crate::products::Tile;
use crate::support::Random;
use halfpixel::emulated::{Device, Shape};

/// Random integers where each row of A has two of each four columns, of its own choice: every sum is exact.
#[test]
fn sparse_products_multiply_what_the_metadata_says() {
    let mut random = Random(3);
    let choices: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let mut a = vec![[0.0_f32; 16]; 16];
    let (mut packed, mut metadata) = (vec![0_u32; 64], vec![u32::MAX; 32]);
    (0..8).for_each(|g| metadata[4 * g] = 0);
    for (row, t) in (0..16).flat_map(|row| (0..4).map(move |t| (row, t))) {
        let columns = choices[random.below(6) as usize];
        let pair = columns.map(|column| {
            a[row][4 * t + column] = random.below(31) as f32 - 15.0;
            Tile::F16K8.operand(a[row][4 * t + column])
        });
        let (g, half) = (row % 8, row / 8);
        packed[2 * (4 * g + t) + half] = pair[0] | pair[1] << 16;
        // Only the first lane's of each four counts.
        metadata[4 * g] |= ((columns[0] | columns[1] << 2) as u32) << (16 * half + 4 * t);
    }
    let b: Vec<[f32; 8]> = (0..16).map(|_| [(); 8].map(|()| random.below(31) as f32 - 15.0)).collect();
    let bits =
        |k: usize, column: usize| Tile::F16K8.operand(b[k][column]) | Tile::F16K8.operand(b[k + 1][column]) << 16;
    let registers = |lane: usize| [0, 8].map(|first| bits(first + 2 * (lane % 4), lane / 4));
    let b_packed: Vec<u32> = (0..32).flat_map(registers).collect();

    let mut device = Device::default();
    let (packed, b_packed) = (device.upload(&packed), device.upload(&b_packed));
    let (metadata, out) = (device.upload(&metadata), device.allocate::<f32>(128));
    let arguments = [&packed.pointer() as _, &b_packed.pointer() as _, &metadata.pointer() as _, &out.pointer() as _];
    device.launch("selftest_mma_sp", Shape::row(1, 32), &arguments).expect("a launch");
    for (i, found) in device.download(&out).expect("a result").into_iter().enumerate() {
        let (lane, r) = (i / 4, i % 4);
        let (row, column) = (lane / 4 + 8 * (r / 2), 2 * (lane % 4) + r % 2);
        let sum: f32 = (0..16).map(|k| a[row][k] * b[k][column]).sum();
        assert_eq!(found, sum + (r + 1) as f32, "({row}, {column})");
    }
}
