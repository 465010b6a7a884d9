//! From how many pixels on hardware draws a quad faster than software does: measured on each device by `bench raster`, and kept
//! in the user's cache. Speed alone hangs on it, never the picture.

use super::Found;
use crate::cache;
use crate::stages::Route;
use std::io;
use std::path::PathBuf;

/// Pixels along the longer side of a quad, where nothing has been measured: ETER section 6.2 calls smaller triangles small.
pub const UNMEASURED: f64 = 16.0;

/// Where it is kept.
fn file() -> io::Result<PathBuf> {
    cache::file("raster.json")
}

/// What was measured on a device with this driver, beside software of a backend, of quads that are large by a rule.
pub fn stored(found: &Found, backend: &str, route: Route) -> Option<f64> {
    let pixels: f64 = cache::get(&file().ok()?, &key(found, backend, route))?;
    // Nobody's file is trusted with what is no number of pixels.
    (pixels.is_finite() && pixels >= 0.0).then_some(pixels)
}

/// Keeps it beside those of other devices; the file it is in.
pub fn store(found: &Found, backend: &str, route: Route, pixels: f64) -> io::Result<PathBuf> {
    let path = file()?;
    cache::put(&path, &key(found, backend, route), &pixels)?;
    Ok(path)
}

fn key(found: &Found, backend: &str, route: Route) -> String {
    format!("{}, {}, {}, beside {backend}, by {route:?}", found.name, found.driver, found.uuid)
}
