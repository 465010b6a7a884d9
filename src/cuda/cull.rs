//! cull, host side: which patches of which instances can be seen. Twin of src/stages/cull.rs.

use super::count::{Count, List};
use super::gpu::pods;
use super::scan::scan;
use super::scene::SceneOnDevice;
use super::selection::Selection;
use super::session::Session;
use super::{Gpu, GpuError, abi};
use crate::stages::lens::Lens;
use crate::stages::{Bound, Cull, Grid, Options};

pods!(abi::Rules abi::Visible);

/// A scene as one frame sees it.
pub(crate) struct Seen<'a> {
    pub scene: &'a SceneOnDevice,
    pub view: abi::View,
    pub rules: abi::Rules,
}

/// What cull and estimate go by. `whole`: the near plane cuts nothing open.
pub(crate) fn rules(lens: &Lens, options: &Options, selection: &Selection, whole: bool) -> abi::Rules {
    debug_assert!(lens.near > 0.0);
    abi::Rules {
        bound: match options.bound {
            Bound::Screen => abi::BoundRule::BOUND_SCREEN,
            Bound::Eter => abi::BoundRule::BOUND_ETER,
            Bound::Filip => abi::BoundRule::BOUND_FILIP,
            Bound::Projective => abi::BoundRule::BOUND_PROJECTIVE,
            Bound::Slefe => abi::BoundRule::BOUND_SLEFE,
        },
        grid: match options.grid {
            Grid::Adaptive => abi::GridRule::GRID_ADAPTIVE,
            Grid::Variable => abi::GridRule::GRID_VARIABLE,
            Grid::Eter => abi::GridRule::GRID_ETER,
            Grid::Eter16 => abi::GridRule::GRID_ETER16,
        },
        cull: match options.cull {
            Cull::Off => abi::CullRule::CULL_OFF,
            Cull::Auto => abi::CullRule::CULL_AUTO,
            Cull::On => abi::CullRule::CULL_ON,
        },
        whole: whole.into(),
        ..selection.rules()
    }
}

/// The patches that are not culled, in the order of instances and patches.
pub(crate) fn cull<G: Gpu>(session: &mut Session<G>, seen: &Seen) -> Result<List<abi::Visible>, GpuError> {
    let Seen { scene, view, rules } = seen;
    let items = Count::known(scene.items);
    let (states, kept) = (session.allocate::<u8>(items.room())?, session.allocate::<u32>(items.room())?);
    let (pointers, instances) = (scene.pointers(), scene.instances());
    session.for_all(
        "cull_patches",
        items,
        &[view, rules, &pointers, &instances, &scene.items, &states.pointer(), &kept.pointer()],
    )?;
    let (slots, total) = scan(session, &kept, items)?;
    let count = session.count_of(total, "patches")?;
    let visible = session.list(count)?;
    session.for_all(
        "cull_compact",
        items,
        &[&scene.items, &states.pointer(), &slots.pointer(), &count, &visible.pointer()],
    )?;
    Ok(visible)
}
