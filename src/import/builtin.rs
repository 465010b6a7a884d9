//! Models that need no file: the teapot, closed primitives, and the hard cases of `stress`.

mod rings;
mod stress;
mod teapot;
mod trimmed;

use crate::geometry::exact::{self, FULL, Frame};
use crate::geometry::{BezierCurve, CurvePiece, PatchPiece};
use crate::model::{Face, Model, Part, Solidity, Surface};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use thiserror::Error;

/// Why there is no such built-in model.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BuiltinError {
    #[error("there is no built-in model '{name}'; there are: {}", names().join(", "))]
    Unknown { name: String },
}

/// The names [`builtin`] knows.
pub fn names() -> Vec<String> {
    let plain = ["teapot", "sphere", "torus", "cylinder", "drum", "rings", "stress"].map(String::from);
    let stress = stress::names().into_iter().map(|name| format!("stress:{name}"));
    plain.into_iter().chain(trimmed::NAMES.map(|name| format!("trimmed:{name}"))).chain(stress).collect()
}

/// A built-in model by name.
///
/// `teapot` is Newell's, 32 bicubic patches, its base at z = 0; `sphere` has radius 1, `torus` radii 1 and 0.4,
/// `cylinder` (the surface: a tube) and `drum` (the body: closed by discs) radius 1 and height 2, all about the origin; `rings`
/// is a pile of 256 closed rings of 224 polynomial bicubic patches each; `stress` is a table of small hard cases and `stress:NAME`
/// one hard case alone; `trimmed:NAME` is a trimmed face or solid.
pub fn builtin(name: &str) -> Result<Model, BuiltinError> {
    let part = match name {
        "teapot" => Some(teapot::teapot()),
        "sphere" => Some(closed("sphere", vec![sphere(1.0)])),
        "torus" => Some(closed("torus", vec![torus(1.0, 0.4)])),
        "cylinder" => Some(part("cylinder", Solidity::Open, vec![drum(1.0, 1.0).swap_remove(1).into()])),
        "drum" => Some(closed("drum", drum(1.0, 1.0))),
        "rings" => Some(closed("rings", rings::pile())),
        "stress" => return Ok(stress::table()),
        _ => match name.split_once(':') {
            Some(("stress", case)) => stress::part_of(case),
            Some(("trimmed", case)) => trimmed::part_of(case),
            _ => None,
        },
    };
    part.map(|part| Model::from_part(name, part)).ok_or_else(|| BuiltinError::Unknown { name: name.into() })
}

/// A part of one face per surface, numbered from 0.
fn part(name: &str, solidity: Solidity, surfaces: Vec<Surface>) -> Part {
    let face = |(k, surface)| Face::new(k as u32, format!("{name} {k}"), surface);
    Part { name: name.into(), faces: surfaces.into_iter().enumerate().map(face).collect(), solidity, ..Part::default() }
}

fn closed(name: &str, faces: Vec<Vec<PatchPiece>>) -> Part {
    part(name, Solidity::Solid, faces.into_iter().map(Surface::from).collect())
}

fn sphere(radius: f64) -> Vec<PatchPiece> {
    exact::sphere(&Frame::IDENTITY, radius, [FULL, [-FRAC_PI_2, FRAC_PI_2]])
}

fn torus(major: f64, minor: f64) -> Vec<PatchPiece> {
    exact::torus(&Frame::IDENTITY, major, minor, [FULL, FULL])
}

/// Bottom, side and top, all as revolutions so that they share their edges bit for bit.
fn drum(radius: f64, half_height: f64) -> Vec<Vec<PatchPiece>> {
    let point = |r: f64, z: f64| DVec3::new(r, 0.0, z);
    let profile =
        [point(0.0, -half_height), point(radius, -half_height), point(radius, half_height), point(0.0, half_height)];
    let turned = |ends: &[DVec3]| {
        let piece = CurvePiece { curve: BezierCurve::line(ends[0], ends[1]), domain: [0.0, 1.0] };
        exact::revolution(&Frame::IDENTITY, &[piece], FULL)
    };
    profile.windows(2).map(turned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_gives_a_good_model() {
        for name in names() {
            let model = builtin(&name).expect(&name);
            assert_eq!(model.name, name);
            assert!(model.bounds().is_some(), "{name}");
            for patch in model.parts.iter().flat_map(|p| &p.faces).flat_map(|f| &f.surface.patches) {
                assert!(patch.patch.points().iter().all(|p| p.is_finite() && p.w > 0.0), "{name}");
            }
        }
    }

    #[test]
    fn unknown_names_list_the_known() {
        for name in ["", "cube", "stress:", "stress:degree0", "stress:degree26", "stress:degree+3", "stress:degree03"] {
            let message = builtin(name).expect_err(name).to_string();
            assert!(message.contains("teapot") && message.contains("stress:room"), "{message}");
        }
    }

    /// Six times the enclosed volume by the divergence theorem, on a fine grid: positive where normals point outward.
    fn six_volumes(part: &Part) -> f64 {
        let cell = 1.0 / 32.0;
        let center = |k: usize| (k as f64 + 0.5) * cell;
        let flux = |surface: &Surface| -> f64 {
            let samples = surface
                .patches
                .iter()
                .flat_map(|p| (0..32 * 32).map(move |k| p.patch.net().surface_point(center(k / 32), center(k % 32))));
            samples.map(|s| s.position.dot(s.du.cross(s.dv))).sum()
        };
        2.0 * cell * cell * part.faces.iter().map(|f| flux(&f.surface)).sum::<f64>()
    }

    #[test]
    fn closed_models_face_outward() {
        use std::f64::consts::PI;
        let torus = 2.0 * PI * PI * 0.16;
        let ring = closed("ring", vec![rings::ring(DVec3::new(3.0, -2.0, 1.0))]);
        let named = |name: &str| builtin(name).expect(name).parts.swap_remove(0);
        for (part, volume) in
            [(named("sphere"), 4.0 / 3.0 * PI), (named("torus"), torus), (named("drum"), 2.0 * PI), (ring, torus)]
        {
            let name = &part.name;
            assert_eq!(part.solidity, Solidity::Solid);
            let found = six_volumes(&part) / 6.0;
            assert!((found / volume - 1.0).abs() < 1e-3, "{name}: {found}, not {volume}");
        }
    }
}
