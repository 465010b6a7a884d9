/// Which lane of a warp runs first after a collective has woken them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LaneOrder {
    #[default]
    Forward = 0,
    Reverse = 1,
    Random = 2,
}

/// Which warp of a block runs first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WarpOrder {
    /// The lowest warp runs until it must wait for others; the fastest order.
    #[default]
    FirstAhead = 0,
    /// The highest one does.
    LastAhead = 1,
    /// All in lockstep.
    Turns = 2,
    Random = 3,
}

/// Which block of a grid starts first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BlockOrder {
    #[default]
    Forward = 0,
    Reverse = 1,
    Random = 2,
}

/// Whose tensor cores are emulated; they differ in the last bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TensorCores {
    /// Compute capability 8.0 to 8.9.
    #[default]
    Sm80 = 0,
    /// 9.0 and later.
    Sm90 = 1,
}

impl TensorCores {
    /// Of a device that has them.
    pub fn compute_capability(self) -> [i32; 2] {
        match self {
            TensorCores::Sm80 => [8, 0],
            TensorCores::Sm90 => [9, 0],
        }
    }
}

/// Who runs when. A right kernel gives the same under every schedule, so tests try [`Schedule::adversarial`] ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    pub lanes: LaneOrder,
    pub warps: WarpOrder,
    pub blocks: BlockOrder,
    /// Of the random orders.
    pub seed: u32,
    pub tensor_cores: TensorCores,
}

impl Schedule {
    /// Orders that bring mistakes to light: lanes and blocks back to front, one warp far ahead of the others, lockstep,
    /// and random ones.
    pub fn adversarial() -> Vec<Self> {
        let of = |lanes, warps, blocks, seed| Self { lanes, warps, blocks, seed, tensor_cores: TensorCores::default() };
        let mut all = vec![
            Self::default(),
            of(LaneOrder::Reverse, WarpOrder::FirstAhead, BlockOrder::Forward, 0),
            of(LaneOrder::Forward, WarpOrder::LastAhead, BlockOrder::Reverse, 0),
            of(LaneOrder::Reverse, WarpOrder::Turns, BlockOrder::Reverse, 0),
            of(LaneOrder::Forward, WarpOrder::Turns, BlockOrder::Random, 1),
        ];
        all.extend((2..6).map(|seed| of(LaneOrder::Random, WarpOrder::Random, BlockOrder::Random, seed)));
        all
    }
}
