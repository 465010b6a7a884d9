//! Memory of Vulkan under kernels: checked as their own is.

use halfpixel::cuda::{Gpu, GpuError};
use halfpixel::emulated::{Device, FaultKind, LaunchError, Shape};
use halfpixel::vulkan::{self, Order, SharedBuffer, Transfers, Validation};

const BYTES: usize = 256;

/// A buffer of Vulkan and commands on it. `None`, with a line that says why, where none can be shared: CI asks for one.
fn shared() -> Option<(SharedBuffer, Transfers)> {
    let device = match vulkan::Device::new(Validation::On, None) {
        Ok(device) if device.shares_memory() && device.found.kind == "cpu" => device,
        other => {
            assert!(std::env::var_os("HALFPIXEL_NEEDS_VULKAN").is_none(), "{other:?}");
            eprintln!("skipped: {other:?} shares no memory with the CPU");
            return None;
        }
    };
    let buffer = SharedBuffer::new(&device, BYTES as u64).expect("a buffer");
    Some((buffer, Transfers::new(&device).expect("commands")))
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks(4).map(|w| u32::from_ne_bytes(w.try_into().expect("four bytes"))).collect()
}

#[test]
fn kernels_and_vulkan_see_the_same_bytes() {
    let Some((memory, mut vulkan)) = shared() else { return };
    let mut device = Device::default();
    let buffer = device.adopt(&memory).expect("mapped memory");
    assert_eq!(buffer.len(), BYTES);
    vulkan.fill(&memory, 7, &Order::default()).expect("a fill");
    assert_eq!(words(&device.download(&buffer).expect("bytes")), [7; BYTES / 4]);
    device.launch("fault_atomic", Shape::row(1, 8), &[&buffer.pointer(), &3_u32]).expect("within the buffer");
    let after: Vec<u32> = (0..BYTES as u32 / 4).map(|k| if k == 3 { 15 } else { 7 }).collect();
    assert_eq!(words(&vulkan.read(&memory, &Order::default()).expect("bytes")), after);
    device.write(&buffer, &[0x5a; BYTES]).expect("as many bytes");
    assert_eq!(vulkan.read(&memory, &Order::default()).expect("bytes"), [0x5a; BYTES]);
    device.clear(&buffer).expect("it is there");
    assert_eq!(vulkan.read(&memory, &Order::default()).expect("bytes"), [0; BYTES]);
    assert!(memory.device().messages().is_empty());
}

#[test]
fn indices_outside_it_are_reported_and_so_is_use_after_free() {
    let Some((memory, mut vulkan)) = shared() else { return };
    let mut device = Device::default();
    let buffer = device.adopt(&memory).expect("mapped memory");
    let fault = |device: &mut Device, index: u32| match device.launch(
        "fault_atomic",
        Shape::row(1, 8),
        &[&buffer.pointer(), &index],
    ) {
        Err(LaunchError::Fault(fault)) => fault.kind,
        other => panic!("{other:?}"),
    };
    assert_eq!(fault(&mut device, BYTES as u32 / 4), FaultKind::OutOfBounds);
    Gpu::free(&mut device, buffer).expect("it is there");
    assert_eq!(fault(&mut device, 0), FaultKind::OutOfBounds);
    let gone = GpuError::Emulated(LaunchError::NoSuchBuffer { bytes: BYTES });
    assert_eq!(Gpu::download(&mut device, &buffer), Err(gone.clone()));
    assert_eq!(Gpu::free(&mut device, buffer), Err(gone));
    // Vulkan still has it.
    vulkan.fill(&memory, 9, &Order::default()).expect("a fill");
    assert_eq!(words(&vulkan.read(&memory, &Order::default()).expect("bytes")), [9; BYTES / 4]);
    assert!(memory.mapped().is_some() && memory.device().messages().is_empty());
}

#[test]
fn it_lives_as_long_as_either_uses_it() {
    let Some((memory, mut vulkan)) = shared() else { return };
    let mut device = Device::default();
    let buffer = device.adopt(&memory).expect("mapped memory");
    vulkan.fill(&memory, 3, &Order::default()).expect("a fill");
    drop((memory, vulkan));
    assert_eq!(words(&device.download(&buffer).expect("bytes")), [3; BYTES / 4]);
}
