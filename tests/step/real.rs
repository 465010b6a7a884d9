//! Real files against the counts that their inventory has.

use crate::support::real_model;
use halfpixel::import::{ImportError, load};
use halfpixel::model::Model;
use std::collections::BTreeSet;
use std::time::Instant;

/// Faces with instances, and stored ones.
const EXPECTED: [(&str, usize, usize); 12] = [
    ("screw.step", 10, 10),
    ("as1-oc-214.stp", 160, 53),
    ("NIST_MBE_PMI_1.stp", 113, 113),
    ("NIST_MBE_PMI_2.stp", 597, 597),
    ("so100_Wrist_Roll_08c.step", 255, 255),
    ("777-200LR.stp", 113, 113),
    ("gmsh_submarine.stp", 12, 12),
    ("11752.stp", 1018, 1018),
    ("ublox_ANN-MB-00_SMA.stp", 1542, 1542),
    ("kicad_Molex_SlimStack_54722-0804_2x40.step", 4852, 4852),
    // Other readers show nothing of it.
    ("brlcad_ap203_periodic_pole_solid.stp", 30, 30),
    ("axom_boxed_sphere.step", 192, 192),
];

fn counts(model: &Model) -> [usize; 2] {
    let faces = model.instances.iter().map(|i| model.parts[i.part].faces.len()).sum();
    [faces, model.parts.iter().map(|p| p.faces.len()).sum()]
}

#[test]
fn every_face_of_every_file() -> Result<(), ImportError> {
    for (name, faces, unique) in EXPECTED {
        let Some(path) = real_model(name) else { continue };
        let start = Instant::now();
        let model = load(&path.to_string_lossy())?;
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{name}: {faces} faces in {} parts, {} instances, {} warnings, {:.1} ms",
            model.parts.len(),
            model.instances.len(),
            model.warnings.len(),
            1e3 * seconds
        );
        for warning in model.warnings.iter().take(3) {
            println!("    {}", warning.message);
        }
        for lost in model.lost.iter().take(5) {
            println!("    LOST {}", lost.message);
        }
        assert!(model.lost.is_empty(), "{name}: {} lost", model.lost.len());
        assert_eq!(counts(&model), [faces, unique], "{name}");
        let ids: BTreeSet<u32> = model.parts.iter().flat_map(|p| &p.faces).map(|f| f.id).collect();
        assert_eq!(ids.len(), unique, "{name}: a face twice");
    }
    Ok(())
}
