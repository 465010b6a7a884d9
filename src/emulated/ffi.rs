//! kernels/host/api.h.
#![allow(unsafe_code)]

use super::memory::{Memory, Range};
use super::schedule::Schedule;
use super::{Fault, FaultKind, LaunchError};
use crate::cuda::Shape;
use std::ffi::{CStr, CString, c_char, c_void};

#[repr(C)]
struct RawLaunch {
    grid: [u32; 3],
    block: [u32; 3],
    dynamic_bytes: u32,
    seed: u32,
    lanes: u8,
    warps: u8,
    blocks: u8,
    tensor_cores: u8,
}

#[repr(C)]
struct RawFault {
    kind: i32,
    block: [u32; 3],
    thread: [u32; 3],
    line: u32,
    column: u32,
    file: [c_char; 256],
    message: [c_char; 1024],
}

enum RawKernel {}
enum RawRun {}

unsafe extern "C" {
    fn hp_find(name: *const c_char) -> *const RawKernel;
    fn hp_next(kernel: *const RawKernel) -> *const RawKernel;
    fn hp_name(kernel: *const RawKernel) -> *const c_char;
    fn hp_parameter_count(kernel: *const RawKernel) -> u32;
    fn hp_parameter_bytes(kernel: *const RawKernel, index: u32) -> u32;
    fn hp_parameter_is_plain_pointer(kernel: *const RawKernel, index: u32) -> bool;
    fn hp_begin(
        kernel: *const RawKernel,
        launch: *const RawLaunch,
        arguments: *const *const c_void,
        ranges: *const Range,
        range_count: usize,
        fault: *mut RawFault,
    ) -> *mut RawRun;
    fn hp_work(run: *mut RawRun);
    fn hp_end(run: *mut RawRun, fault: *mut RawFault);
}

pub(super) fn kernels() -> Vec<String> {
    let mut names = Vec::new();
    // SAFETY: the list of kernels is complete before `main` and never changes; its names are string literals.
    unsafe {
        let mut kernel = hp_next(std::ptr::null());
        while !kernel.is_null() {
            names.push(CStr::from_ptr(hp_name(kernel)).to_string_lossy().into_owned());
            kernel = hp_next(kernel);
        }
    }
    names
}

pub(super) fn launch(
    kernel: &str,
    shape: &Shape,
    schedule: &Schedule,
    threads: usize,
    arguments: &[&[u8]],
    memory: &mut Memory,
) -> Result<(), LaunchError> {
    let found = find(kernel)?;
    check_arguments(kernel, found, arguments)?;
    let arguments = Arguments::new(arguments);
    let ranges = memory.ranges();
    let launch = RawLaunch {
        grid: shape.grid,
        block: shape.block,
        dynamic_bytes: shape.dynamic_bytes,
        seed: schedule.seed,
        lanes: schedule.lanes as u8,
        warps: schedule.warps as u8,
        blocks: schedule.blocks as u8,
        tensor_cores: schedule.tensor_cores as u8,
    };
    let mut fault = no_fault();
    // SAFETY: the kernel is of the list; arguments agree with its parameters in number and size; arguments and ranges
    // outlive hp_end below; the memory behind the ranges is borrowed exclusively until then.
    let run = unsafe {
        let (p, r) = (arguments.pointers.as_ptr(), ranges.as_ptr());
        hp_begin(found, &launch, p, r, ranges.len(), &mut fault)
    };
    if !run.is_null() {
        let blocks = shape.grid.iter().map(|&n| n as usize).product::<usize>();
        work(Run(run), threads.min(blocks));
        // SAFETY: all workers are done, and nothing uses the run after this.
        unsafe { hp_end(run, &mut fault) };
    }
    result(kernel, &fault)
}

fn find(kernel: &str) -> Result<*const RawKernel, LaunchError> {
    let unknown = || LaunchError::UnknownKernel(kernel.to_owned());
    let name = CString::new(kernel).map_err(|_| unknown())?;
    // SAFETY: the name is a C string.
    let found = unsafe { hp_find(name.as_ptr()) };
    if found.is_null() { Err(unknown()) } else { Ok(found) }
}

fn check_arguments(kernel: &str, found: *const RawKernel, arguments: &[&[u8]]) -> Result<(), LaunchError> {
    // SAFETY: the kernel is of the list.
    let expected = unsafe { hp_parameter_count(found) } as usize;
    if expected != arguments.len() {
        return Err(LaunchError::ArgumentCount { kernel: kernel.to_owned(), expected, given: arguments.len() });
    }
    for (index, argument) in arguments.iter().enumerate() {
        // SAFETY: the index is below the number of parameters.
        let expected = unsafe { hp_parameter_bytes(found, index as u32) } as usize;
        if expected != argument.len() {
            let (kernel, given) = (kernel.to_owned(), argument.len());
            return Err(LaunchError::ArgumentSize { kernel, index, expected, given });
        }
        // SAFETY: as above.
        if unsafe { hp_parameter_is_plain_pointer(found, index as u32) } {
            return Err(LaunchError::PlainPointer { kernel: kernel.to_owned(), index });
        }
    }
    Ok(())
}

/// Copies of the arguments, aligned for any parameter.
struct Arguments {
    pointers: Vec<*const c_void>,
    _values: Vec<Vec<u128>>,
}

impl Arguments {
    fn new(arguments: &[&[u8]]) -> Self {
        let copy = |bytes: &&[u8]| {
            let words = bytes.chunks(16).map(|part| {
                let mut word = [0; 16];
                word[..part.len()].copy_from_slice(part);
                u128::from_ne_bytes(word)
            });
            words.collect::<Vec<u128>>()
        };
        let values: Vec<Vec<u128>> = arguments.iter().map(copy).collect();
        Self { pointers: values.iter().map(|v| v.as_ptr().cast()).collect(), _values: values }
    }
}

#[derive(Clone, Copy)]
struct Run(*mut RawRun);
// SAFETY: hp_work is made to be called by several threads at once.
unsafe impl Send for Run {}
// SAFETY: as above.
unsafe impl Sync for Run {}

fn work(run: Run, threads: usize) {
    // SAFETY: the run has begun and does not end before this returns.
    let blocks = move || {
        let Run(run) = { run };
        unsafe { hp_work(run) }
    };
    if threads < 2 {
        return blocks();
    }
    rayon::scope(|scope| (0..threads).for_each(|_| scope.spawn(move |_| blocks())));
}

fn no_fault() -> RawFault {
    RawFault { kind: 0, block: [0; 3], thread: [0; 3], line: 0, column: 0, file: [0; 256], message: [0; 1024] }
}

fn result(kernel: &str, fault: &RawFault) -> Result<(), LaunchError> {
    if fault.kind == 0 {
        return Ok(());
    }
    let text = |chars: &[c_char]| {
        let bytes: Vec<u8> = chars.iter().map(|&c| c as u8).take_while(|&c| c != 0).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    Err(LaunchError::Fault(Box::new(Fault {
        kind: FaultKind::from_number(fault.kind),
        kernel: kernel.to_owned(),
        file: text(&fault.file),
        line: fault.line,
        block: fault.block,
        thread: fault.thread,
        message: text(&fault.message),
    })))
}
