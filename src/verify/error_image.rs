//! The error image, coloured as in Yeo's figure 12 (Yeo, Bin, Peters. Efficient pixel-accurate rendering of animated
//! curved surfaces. 2012).

use super::check::Verdict;
use std::io::Write;

/// What the error image shows of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Class {
    #[default]
    Unchecked,
    Background,
    /// Largest of grid and parametric error below 0.1 pixels.
    Tenth,
    /// Up to half a pixel.
    Half,
    /// Up to a pixel.
    Whole,
    /// A pixel or more.
    Beyond,
    Crack,
    CoveringFailure,
    DepthFailure,
}

/// RGB of each class, in its order.
const COLORS: [[u8; 3]; 9] = [
    [0, 0, 0],
    [250, 246, 236],
    [176, 176, 176],
    [66, 110, 220],
    [60, 170, 75],
    [220, 40, 40],
    [255, 0, 255],
    [255, 150, 0],
    [0, 230, 230],
];

/// One class a pixel, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ErrorMap {
    size: [u32; 2],
    classes: Vec<Class>,
}

impl Class {
    pub(super) fn of(drawn: bool, verdict: &Verdict) -> Self {
        match verdict.worst_error() {
            _ if verdict.crack => Self::Crack,
            _ if verdict.covering_failure => Self::CoveringFailure,
            _ if verdict.depth_failure => Self::DepthFailure,
            _ if !drawn => Self::Background,
            Some(e) if e < 0.1 => Self::Tenth,
            Some(e) if e <= super::check::HALF_PIXEL => Self::Half,
            Some(e) if e < 1.0 => Self::Whole,
            _ => Self::Beyond,
        }
    }
}

impl ErrorMap {
    pub(super) fn new(size: [u32; 2]) -> Self {
        Self { size, classes: vec![Class::Unchecked; size[0] as usize * size[1] as usize] }
    }

    pub(super) fn set(&mut self, at: usize, class: Class) {
        self.classes[at] = class;
    }

    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    pub fn at(&self, x: u32, y: u32) -> Class {
        self.classes[y as usize * self.size[0] as usize + x as usize]
    }

    /// Writes it as a PNG of the nine colours.
    pub fn write_png(&self, to: impl Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(to, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(COLORS.as_flattened());
        let mut writer = encoder.write_header()?;
        let indices: Vec<u8> = self.classes.iter().map(|&class| class as u8).collect();
        writer.write_image_data(&indices)?;
        writer.finish()
    }
}
