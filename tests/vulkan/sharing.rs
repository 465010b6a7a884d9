//! Memory and semaphores between two devices, each of an instance of its own: what is shared with CUDA in the same way.

use crate::skip;
use halfpixel::cuda::{self, Gpu, Stream};
use halfpixel::emulated;
use halfpixel::vulkan::{
    Device, Handle, Order, Semaphores, SharedBuffer, SharedSemaphore, Transfers, Validation, VulkanError,
};
use std::fs::File;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Some count this process's files: one test at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// Two devices whose calls are validated. `None`, with a line that says why, where there are none that share memory.
fn devices() -> Option<(MutexGuard<'static, ()>, [Arc<Device>; 2])> {
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let both = || Ok([Device::new(Validation::On, None)?, Device::new(Validation::On, None)?]);
    match both() {
        Ok([a, _]) if !a.shares_memory() => {
            eprintln!("skipped: {} shares no memory", a.found.name);
            None
        }
        Ok(both) => Some((alone, both)),
        Err(error) => {
            skip(&error);
            None
        }
    }
}

fn assert_silent(devices: &[Arc<Device>]) {
    let all = devices.iter().flat_map(|d| d.messages());
    // Drivers of Mesa say themselves what they return.
    let messages: Vec<String> = all.filter(|m| m != "VK_ERROR_INVALID_EXTERNAL_HANDLE").collect();
    assert!(messages.is_empty(), "{messages:#?}");
}

/// The buffer again, on another device.
fn imported(device: &Arc<Device>, of: &SharedBuffer) -> SharedBuffer {
    let handle = of.export().expect("a handle");
    SharedBuffer::import(device, handle, of.bytes(), of.allocation()).expect("the same memory")
}

/// All words of a buffer are this one; where the host sees them, it sees the same.
fn assert_all(on: &mut Transfers, buffer: &SharedBuffer, word: u32) {
    let bytes = on.read(buffer, &Order::default()).expect("bytes");
    assert!(bytes.len() as u64 == buffer.bytes() && bytes.chunks(4).all(|w| w == word.to_ne_bytes()), "{word:#x}");
    if let Some(first) = buffer.mapped() {
        // SAFETY: the mapping has as many bytes, and nothing runs on either device.
        assert_eq!(bytes, unsafe { std::slice::from_raw_parts(first, bytes.len()) });
    }
}

#[test]
fn two_devices_see_the_same_memory() {
    let Some((_alone, [a, b])) = devices() else { return };
    for bytes in [0, 4, 4096, 1_000_000] {
        let theirs = SharedBuffer::new(&a, bytes).expect("a buffer");
        let ours = imported(&b, &theirs);
        assert!(ours.bytes() == theirs.bytes() && ours.bytes() >= bytes && theirs.allocation() >= bytes);
        assert!(ours.address() != 0 && theirs.address() != 0);
        // What one writes, the other reads into a buffer that only it has.
        let copy = SharedBuffer::new(&b, bytes).expect("a buffer");
        let [mut on_a, mut on_b] = [&a, &b].map(|d| Transfers::new(d).expect("commands"));
        on_a.fill(&theirs, 0x1234_5678, &Order::default()).expect("a fill");
        on_b.copy(&ours, &copy, &Order::default()).expect("a copy");
        assert_all(&mut on_b, &copy, 0x1234_5678);
        // And back.
        on_b.fill(&ours, 0x9abc_def0, &Order::default()).expect("a fill");
        let back = SharedBuffer::new(&a, bytes).expect("a buffer");
        on_a.copy(&theirs, &back, &Order::default()).expect("a copy");
        assert_all(&mut on_a, &back, 0x9abc_def0);
        assert_all(&mut on_a, &theirs, 0x9abc_def0);
        // It lives until both have let it go.
        drop(theirs);
        on_b.copy(&ours, &copy, &Order::default()).expect("a copy");
        assert_all(&mut on_b, &copy, 0x9abc_def0);
    }
    assert_silent(&[a, b]);
}

#[test]
fn semaphores_order_two_devices() {
    let Some((_alone, [a, b])) = devices() else { return };
    let kind = a.shares_semaphores().min(b.shares_semaphores());
    if kind == Semaphores::None {
        eprintln!("skipped: {} ({}) can't export and import semaphores", a.found.name, a.found.driver);
        let refused = SharedSemaphore::new(&a, Semaphores::Binary).expect_err("nothing to share");
        assert_eq!(refused.to_string(), format!("{} can't share semaphores with other APIs", a.found.name));
        return;
    }
    let theirs = SharedBuffer::new(&a, 4096).expect("a buffer");
    let ours = imported(&b, &theirs);
    let written = SharedSemaphore::new(&a, kind).expect("a semaphore");
    let awaited = SharedSemaphore::import(&b, written.export().expect("a handle"), kind).expect("the same semaphore");
    let copy = SharedBuffer::new(&b, 4096).expect("a buffer");
    let [mut on_a, mut on_b] = [&a, &b].map(|d| Transfers::new(d).expect("commands"));
    for value in 1..20 {
        let (signal, wait) = (Some((&written, value)), Some((&awaited, value)));
        thread::scope(|scope| {
            let filling = scope.spawn(|| {
                thread::sleep(Duration::from_millis(value % 3));
                on_a.fill(&theirs, value as u32, &Order { signal, ..Order::default() }).expect("a fill");
            });
            // A binary semaphore may be waited for only once its signal is on its way.
            if kind == Semaphores::Binary {
                filling.join().expect("a fill");
            }
            on_b.copy(&ours, &copy, &Order { wait, ..Order::default() }).expect("a copy");
        });
        assert_all(&mut on_b, &copy, value as u32);
    }
    drop([on_a, on_b]);
    assert_silent(&[a, b]);
}

#[test]
fn the_host_and_a_device_keep_order_by_a_timeline() {
    let Some((_alone, [a, _b])) = devices() else { return };
    let timeline = SharedSemaphore::local(&a).expect("a timeline");
    let buffer = SharedBuffer::new(&a, 64).expect("a buffer");
    let mut on_a = Transfers::new(&a).expect("commands");
    on_a.fill(&buffer, 1, &Order::default()).expect("a fill");
    thread::scope(|scope| {
        let order = Order { wait: Some((&timeline, 1)), signal: Some((&timeline, 2)) };
        let filling = scope.spawn(move || {
            on_a.fill(&buffer, 2, &order).expect("a fill");
            assert_all(&mut on_a, &buffer, 2);
        });
        // Nothing happens before the host says so.
        assert_eq!(timeline.wait(2, Duration::from_millis(50)), Ok(false));
        timeline.signal(1).expect("a signal");
        assert_eq!(timeline.wait(2, Duration::from_secs(60)), Ok(true));
        filling.join().expect("the fill");
    });
    let refused = timeline.export().expect_err("it is not made for it").to_string();
    assert!(refused.ends_with("can't share a semaphore that is not made for it with other APIs"), "{refused}");
    drop(timeline);
    assert_silent(&[a]);
}

#[test]
fn refuses_handles_of_other_things() {
    let Some((_alone, [a, _b])) = devices() else { return };
    let wrong = || {
        let file = File::open("/dev/null").expect("a file");
        let (pipe, _) = std::io::pipe().expect("a pipe");
        let this = File::open(file!()).expect("a file");
        [file.into(), pipe.into(), this.into()].map(Handle)
    };
    for handle in wrong() {
        let refused = SharedBuffer::import(&a, handle, 4096, 4096).expect_err("no memory");
        assert_eq!(refused, VulkanError::WrongHandle { what: "memory" });
        assert_eq!(refused.to_string(), "a handle that was to be memory names something else");
    }
    let theirs = SharedBuffer::new(&a, 4096).expect("a buffer");
    SharedBuffer::import(&a, theirs.export().expect("a handle"), 1 << 20, 4096).expect_err("too small");
    if a.shares_semaphores() > Semaphores::None {
        for handle in wrong() {
            SharedSemaphore::import(&a, handle, Semaphores::Binary).expect_err("no semaphore");
        }
    }
    drop(theirs);
    assert_silent(&[a]);
}

#[test]
fn can_be_off() {
    let Some((_alone, [a, _b])) = devices() else { return };
    let unshared = Device::unshared(Validation::On, None).expect("it is there with sharing");
    assert!(!unshared.shares_memory());
    assert_eq!(unshared.shares_semaphores(), Semaphores::None);
    let says = |device: &Device| device.found.absent.iter().any(|a| a.starts_with("no memory that CUDA can import"));
    assert!(says(&unshared) && !says(&a), "{:?}", unshared.found.absent);
    let refused = SharedBuffer::new(&unshared, 64).expect_err("nothing is shared").to_string();
    assert_eq!(refused, format!("{} can't share memory with other APIs", unshared.found.name));
    let handle = SharedBuffer::new(&a, 64).and_then(|b| b.export()).expect("a handle");
    SharedBuffer::import(&unshared, handle, 64, 64).expect_err("nothing is shared");
    for kind in [Semaphores::None, Semaphores::Binary, Semaphores::Timeline] {
        SharedSemaphore::new(&unshared, kind).expect_err("nothing is shared");
    }
    assert_silent(&[a, unshared]);
}

#[test]
#[cfg(target_os = "linux")]
fn closes_all_handles() {
    let Some((_alone, [a, b])) = devices() else { return };
    let open = || std::fs::read_dir("/proc/self/fd").expect("a list").count();
    let round = || {
        let theirs = SharedBuffer::new(&a, 4096).expect("a buffer");
        let unused = theirs.export().expect("a handle");
        let ours = imported(&b, &theirs);
        let null = Handle(File::open("/dev/null").expect("a file").into());
        SharedBuffer::import(&b, null, 4096, 4096).expect_err("no memory");
        drop((theirs, unused, ours));
    };
    round();
    let before = open();
    (0..10).for_each(|_| round());
    // Tests beside this one open files too, but not for long.
    let closed = (0..500).any(|_| {
        thread::sleep(Duration::from_millis(10));
        open() <= before
    });
    assert!(closed, "{} open files, {before} before", open());
    assert_silent(&[a, b]);
}

/// What CUDA and Vulkan do to one buffer, in the order that a pair of semaphores gives: by kernels first, by Vulkan first.
fn take_turns<G: Gpu>(gpu: &mut G, device: &Arc<Device>, semaphores: Option<[Arc<SharedSemaphore>; 2]>) {
    let memory = SharedBuffer::new(device, 1 << 16).expect("a buffer");
    let mut vulkan = Transfers::new(device).expect("commands");
    let buffer = gpu.adopt(&memory).expect("the same memory");
    assert_eq!(buffer.len() as u64, memory.bytes());
    for value in 1..10 {
        vulkan.fill(&memory, u32::MAX, &Order::default()).expect("a fill");
        gpu.clear(&buffer).expect("it is there");
        let [mut first, mut last] = [Order::default(); 2];
        match &semaphores {
            Some([theirs, ours]) => {
                gpu.signal(theirs, value).expect("a signal");
                first.wait = Some((theirs, value));
                last.signal = Some((ours, value));
            }
            None => gpu.finish().expect("the end"),
        }
        assert!(vulkan.read(&memory, &first).expect("bytes").iter().all(|&byte| byte == 0));
        let word = 0x0101_0101 * value as u32;
        vulkan.fill(&memory, word, &last).expect("a fill");
        if let Some([_, ours]) = &semaphores {
            gpu.wait(ours, value).expect("signalled");
        }
        assert!(gpu.download(&buffer).expect("bytes").iter().all(|&byte| u64::from(byte) == value));
    }
    gpu.free(buffer).expect("it is there");
    gpu.download(&buffer).expect_err("it is gone");
    assert_all(&mut vulkan, &memory, 0x0909_0909);
}

#[test]
fn emulated_kernels_take_turns_with_vulkan() {
    let Some((_alone, [a, _b])) = devices() else { return };
    if a.found.kind != "cpu" {
        return eprintln!("skipped: {} is no CPU", a.found.name);
    }
    let timeline = || Arc::new(SharedSemaphore::local(&a).expect("a timeline"));
    for semaphores in [None, Some([timeline(), timeline()])] {
        take_turns(&mut emulated::Device::default(), &a, semaphores);
    }
    assert_silent(&[a]);
}

#[test]
fn cuda_takes_turns_with_vulkan() {
    let missing = cuda::missing();
    if !missing.is_empty() {
        return eprintln!("skipped: {missing:?}");
    }
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut stream = Stream::new(0).expect("a stream");
    let device = match Device::new(Validation::On, stream.vulkan_uuid()) {
        Ok(device) if device.shares_memory() => device,
        other => return eprintln!("skipped: {} with Vulkan: {other:?}", stream.name()),
    };
    let kind = stream.semaphores().min(device.shares_semaphores());
    let semaphore = || Arc::new(SharedSemaphore::new(&device, kind).expect("a semaphore"));
    take_turns(&mut stream, &device, None);
    if kind > Semaphores::None {
        take_turns(&mut stream, &device, Some([semaphore(), semaphore()]));
    }
    drop(stream);
    assert_silent(&[device]);
}
