use halfpixel::emulated::{Device, Fault, LaunchError, Schedule};

/// Numbers without a pattern (xorshift64*), the same in every run.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// From -1 to 1.
    pub fn unit(&mut self) -> f64 {
        self.below(1 << 30) as f64 / f64::from(1 << 29) - 1.0
    }
}

/// Runs `test` under every adversarial schedule, on one thread of the CPU and on several; all results must be equal.
pub fn under_all_schedules<R: PartialEq>(test: impl Fn(&mut Device) -> R) -> R {
    let mut first = None;
    for schedule in Schedule::adversarial() {
        for threads in [1, 3] {
            let found = test(&mut Device::new(schedule, threads));
            match &first {
                None => first = Some(found),
                Some(first) => assert!(*first == found, "another result under {schedule:?}, {threads} threads"),
            }
        }
    }
    first.expect("there are schedules")
}

/// The fault that a launch ended with.
pub fn fault(result: Result<(), LaunchError>) -> Fault {
    match result {
        Err(LaunchError::Fault(fault)) => *fault,
        other => panic!("a fault was expected, not {other:?}"),
    }
}
