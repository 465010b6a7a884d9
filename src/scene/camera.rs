//! Cameras: the named views and what `--eye`, `--target`, `--zoom` make of them (DESIGN section 3).

use super::Bounds;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How camera space becomes pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Projection {
    /// `x = focal * x_c / z + center`, focal in pixels.
    Perspective { focal: f64 },
    /// `x = scale * x_c + center`, scale in pixels a unit.
    Orthographic { scale: f64 },
}

/// The seven named directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum View {
    #[default]
    Iso,
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
}

/// What a user asks for; `ViewSpec::camera` turns it into a camera for a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSpec {
    pub size: [u32; 2],
    pub view: View,
    pub orthographic: bool,
    /// Vertical field of view in degrees.
    pub fov: f64,
    pub zoom: f64,
    pub eye: Option<DVec3>,
    pub target: Option<DVec3>,
    pub up: Option<DVec3>,
}

#[derive(Clone, Debug, PartialEq, Error)]
pub enum CameraError {
    #[error("the model has no extent to look at; give --eye and --target")]
    EmptyBounds,
    #[error("--{what} is {value}; it must be {must}")]
    BadValue { what: &'static str, value: String, must: &'static str },
    #[error("the eye and the target are the same point")]
    EyeIsTarget,
}

/// A camera: right-handed frame, z along the view direction, x right, y down, pixels after projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub size: [u32; 2],
    pub eye: DVec3,
    pub right: DVec3,
    pub down: DVec3,
    pub forward: DVec3,
    pub projection: Projection,
    /// What is nearer than this is not drawn.
    pub near: f64,
    /// Depth range of the orthographic depth, from `near`.
    pub extent: f64,
}

/// Largest image side; sub-pixel coordinates then fit the rasteriser's integers.
pub const MAX_SIDE: u32 = 16384;

impl Default for ViewSpec {
    fn default() -> Self {
        Self {
            size: [1280, 720],
            view: View::Iso,
            orthographic: false,
            fov: 45.0,
            zoom: 1.0,
            eye: None,
            target: None,
            up: None,
        }
    }
}

impl View {
    pub const ALL: [View; 7] = [View::Iso, View::Front, View::Back, View::Left, View::Right, View::Top, View::Bottom];

    /// From the target towards the eye (not normalised).
    fn direction(self) -> DVec3 {
        match self {
            View::Iso => DVec3::new(1.0, -1.0, 0.8),
            View::Front => -DVec3::Y,
            View::Back => DVec3::Y,
            View::Left => -DVec3::X,
            View::Right => DVec3::X,
            View::Top => DVec3::Z,
            View::Bottom => -DVec3::Z,
        }
    }

    fn up(self) -> DVec3 {
        match self {
            View::Top => DVec3::Y,
            View::Bottom => -DVec3::Y,
            _ => DVec3::Z,
        }
    }
}

impl ViewSpec {
    /// The camera that looks at `bounds` as asked.
    pub fn camera(&self, bounds: &Bounds) -> Result<Camera, CameraError> {
        self.check()?;
        let radius = bounds.radius();
        if !(radius.is_finite() && bounds.center().is_finite()) {
            return Err(CameraError::EmptyBounds);
        }
        // A model that is a single point still has a picture.
        let radius = if radius > 0.0 { radius } else { bounds.center().length().max(1.0) * 1e-9 };
        let half_fov = self.fov.to_radians() / 2.0;
        let [w, h] = self.size.map(f64::from);
        let focal = h / 2.0 / half_fov.tan();
        let half_smaller = (w.min(h) / 2.0 / focal).atan();
        let distance = radius * 1.05 / half_smaller.sin();
        let center = bounds.center();
        let target = self.target.unwrap_or(center);
        let eye = self.eye.unwrap_or_else(|| target + self.view.direction().normalize() * distance);
        let eye_distance = (center - eye).length();
        if !eye_distance.is_finite() {
            let value = format!("{:e} away from the model", (center - eye).abs().max_element());
            return Err(CameraError::BadValue { what: "eye", value, must: "nearer" });
        }
        let forward = (target - eye).try_normalize().ok_or(CameraError::EyeIsTarget)?;
        let up = self.up.unwrap_or(if self.eye.is_some() { DVec3::Z } else { self.view.up() });
        let right = forward.cross(up.normalize_or_zero());
        // Looking along the up vector: any other will do.
        let right = if right.length() > 1e-9 { right } else { forward.cross(forward.any_orthogonal_vector()) };
        let right = right.normalize();
        // Depth, not distance: a model at the side of a wide image is nearer in depth than it is far.
        let near = (0.99 * (forward.dot(center - eye) - radius)).max(1e-4 * radius);
        let projection = if self.orthographic {
            Projection::Orthographic { scale: w.min(h) / 2.0 / (1.05 * radius) * self.zoom }
        } else {
            Projection::Perspective { focal: focal * self.zoom }
        };
        // One part in a hundred to spare: the depth of what is drawn stays above 0.
        let extent = 1.01 * ((eye_distance + radius) - near).max(radius);
        Ok(Camera { size: self.size, eye, right, down: forward.cross(right), forward, projection, near, extent })
    }

    fn check(&self) -> Result<(), CameraError> {
        let bad = |what, value: String, must| Err(CameraError::BadValue { what, value, must });
        if self.size.iter().any(|&s| s == 0 || s > MAX_SIDE) {
            return bad("size", format!("{}x{}", self.size[0], self.size[1]), "1 to 16384 pixels a side");
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return bad("fov", self.fov.to_string(), "between 0 and 180 degrees");
        }
        if !(self.zoom > 0.0 && self.zoom.is_finite()) {
            return bad("zoom", self.zoom.to_string(), "positive");
        }
        for (what, point) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if let Some(p) = point.filter(|p| !p.is_finite()) {
                return bad(what, p.to_string(), "finite");
            }
        }
        match self.up {
            Some(up) if up == DVec3::ZERO => bad("up", up.to_string(), "longer than zero"),
            _ => Ok(()),
        }
    }
}

impl Camera {
    /// Image centre in pixels.
    pub fn center(&self) -> DVec2 {
        DVec2::new(f64::from(self.size[0]), f64::from(self.size[1])) * 0.5
    }

    /// World to camera coordinates (x right, y down, z forward), in model units.
    pub fn to_camera(&self, world: DVec3) -> DVec3 {
        let p = world - self.eye;
        DVec3::new(self.right.dot(p), self.down.dot(p), self.forward.dot(p))
    }

    /// Camera coordinates to pixels; meaningless where z is not positive in perspective.
    pub fn project(&self, camera: DVec3) -> DVec2 {
        let xy = camera.truncate();
        self.center()
            + match self.projection {
                Projection::Perspective { focal } => xy * (focal / camera.z),
                Projection::Orthographic { scale } => xy * scale,
            }
    }

    /// The ray through image point (x, y) in camera coordinates: `origin + z * step` has camera depth z.
    pub fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let d = DVec2::new(x, y) - self.center();
        match self.projection {
            Projection::Perspective { focal } => (DVec3::ZERO, (d / focal).extend(1.0)),
            Projection::Orthographic { scale } => ((d / scale).extend(0.0), DVec3::Z),
        }
    }

    /// Size of a pixel in model units at camera depth z.
    pub fn pixel_size(&self, z: f64) -> f64 {
        match self.projection {
            Projection::Perspective { focal } => z / focal,
            Projection::Orthographic { scale } => 1.0 / scale,
        }
    }

    /// Stored depth of camera depth z: larger is nearer, 0 is background.
    pub fn stored_depth(&self, z: f64) -> f64 {
        match self.projection {
            Projection::Perspective { .. } => self.near / z,
            Projection::Orthographic { .. } => 1.0 - (z - self.near) / self.extent,
        }
    }

    /// Camera depth of a stored depth.
    pub fn camera_depth(&self, stored: f64) -> f64 {
        match self.projection {
            Projection::Perspective { .. } => self.near / stored,
            Projection::Orthographic { .. } => self.near + (1.0 - stored) * self.extent,
        }
    }
}
