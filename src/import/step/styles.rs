//! Colours (ISO 10303-46): from styled items to the colour of their surfaces.

use super::args::Value;
use super::file::File;
use super::kinds::Kind;
use foldhash::{HashMap, HashSet};

/// From a styled item to its colour pass fewer entities than this.
const MAX_DEPTH: u8 = 10;

/// Linear RGB of styled entities, by their numbers.
#[derive(Default)]
pub(super) struct Styles {
    items: HashMap<u32, Styled>,
    hidden: HashSet<u32>,
    /// In the order of the file.
    pub overrides: Vec<Override>,
}

/// A colour that an item has in one place of the assembly only (`CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM`).
pub(super) struct Override {
    pub item: u32,
    pub color: [f32; 3],
    /// Numbers that the way from the top to that place passes, all of them: of usages, of what places them, of mapped
    /// items, of representations.
    pub contexts: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Styled {
    color: [f32; 3],
    overriding: bool,
}

impl Styles {
    pub fn new(file: &File) -> Self {
        let mut styles = Self::default();
        for entity in file.entities() {
            if entity.kind == Kind::Invisibility {
                let items = entity.args().and_then(|mut args| args.references()).unwrap_or_default();
                items.into_iter().for_each(|item| hide(file, item, &mut styles.hidden));
            }
            let overriding = match entity.kind {
                Kind::StyledItem => false,
                Kind::OverRidingStyledItem | Kind::ContextDependentOverRidingStyledItem => true,
                _ => continue,
            };
            let Ok(args) = entity.args() else { continue };
            let mut args = args.skip(1);
            let Ok(assigned) = args.references() else { continue };
            let Some(color) = assigned.into_iter().find_map(|style| color_of(file, style, 0)) else { continue };
            let Some(item) = args.optional_reference() else { continue };
            if entity.kind == Kind::ContextDependentOverRidingStyledItem {
                let contexts = args.skip(1).references().unwrap_or_default();
                if !contexts.is_empty() {
                    styles.overrides.push(Override { item, color, contexts });
                    continue;
                }
            }
            let styled = styles.items.entry(item).or_insert(Styled { color, overriding });
            if overriding || !styled.overriding {
                *styled = Styled { color, overriding };
            }
        }
        styles
    }

    pub fn item(&self, id: u32) -> Option<[f32; 3]> {
        self.items.get(&id).map(|s| s.color)
    }

    /// Whether the file says that this is not to be seen.
    pub fn is_hidden(&self, id: u32) -> bool {
        self.hidden.contains(&id)
    }
}

/// What an invisible item stands for (ISO 10303-46, `invisibility`): a style for what it styles, a layer for all that is
/// on it, anything else for itself.
fn hide(file: &File, id: u32, hidden: &mut HashSet<u32>) {
    let styled = |id: u32| {
        let entity = file.get(id).ok()?;
        matches!(entity.kind, Kind::StyledItem | Kind::OverRidingStyledItem).then_some(())?;
        entity.args().ok()?.skip(2).optional_reference()
    };
    let layer = file.args(id, Kind::PresentationLayerAssignment, "a layer").and_then(|args| args.skip(2).references());
    let items = layer.unwrap_or_else(|_| vec![id]);
    hidden.extend(items.into_iter().map(|item| styled(item).unwrap_or(item)));
}

/// The first colour of a surface that is reached from `id`.
fn color_of(file: &File, id: u32, depth: u8) -> Option<[f32; 3]> {
    if depth > MAX_DEPTH {
        return None;
    }
    let entity = file.get(id).ok()?;
    let mut args = entity.args().ok()?;
    let follow = |id: u32| color_of(file, id, depth + 1);
    match entity.kind {
        Kind::ColourRgb => {
            let mut args = args.skip(1);
            let mut channel = || args.number().ok().map(linear);
            Some([channel()?, channel()?, channel()?])
        }
        Kind::DraughtingPreDefinedColour => named(&args.text()),
        Kind::PresentationStyleAssignment | Kind::PresentationStyleByContext => {
            args.references().ok()?.into_iter().find_map(follow)
        }
        Kind::SurfaceSideStyle | Kind::FillAreaStyle => args.skip(1).references().ok()?.into_iter().find_map(follow),
        Kind::SurfaceStyleUsage | Kind::FillAreaStyleColour => follow(args.skip(1).optional_reference()?),
        Kind::SurfaceStyleFillArea => follow(args.optional_reference()?),
        Kind::SurfaceStyleRendering | Kind::SurfaceStyleRenderingWithProperties => args.find_map(|value| match value {
            Value::Reference(id) => follow(id),
            _ => None,
        }),
        _ => None,
    }
}

/// Files have colours as screens do: sRGB (IEC 61966-2-1).
fn linear(value: f64) -> f32 {
    let value = value.clamp(0.0, 1.0);
    let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

fn named(name: &str) -> Option<[f32; 3]> {
    Some(match name {
        "black" => [0.0, 0.0, 0.0],
        "red" => [1.0, 0.0, 0.0],
        "green" => [0.0, 1.0, 0.0],
        "blue" => [0.0, 0.0, 1.0],
        "yellow" => [1.0, 1.0, 0.0],
        "magenta" => [1.0, 0.0, 1.0],
        "cyan" => [0.0, 1.0, 1.0],
        "white" => [1.0, 1.0, 1.0],
        _ => return None,
    })
}
