//! The options of a depth map.

use super::Fault;

/// The method that measures depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// The least residual of H_f·n − H_n·f over all depths, by few filters.
    Gram,
    /// Differences of Laplacian energy, as the text has it (B§4); needs a plane sweep.
    Laplacian,
    /// The spatial-domain transform: closed form, the cheapest.
    Stm,
}

/// The window that a pixel's depth is taken over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// As large as the texture needs and the depth's relief allows, pixel by pixel.
    Auto,
    /// A Gaussian of this standard deviation, in pixels.
    Px(f64),
}

/// Whether a median follows, and the side of its square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Median {
    /// No median filter.
    None,
    /// 3 × 3 pixels.
    Three,
    /// 5 × 5 pixels.
    Five,
}

impl Median {
    /// The side of the square in pixels; 0 for none.
    pub fn side_px(self) -> usize {
        match self {
            Median::None => 0,
            Median::Three => 3,
            Median::Five => 5,
        }
    }
}

/// The options of a depth map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthOptions {
    /// How depth is measured.
    pub method: Method,
    /// Over which window.
    pub window: Window,
    /// Whether a shift between the pictures is measured and taken out.
    pub align: bool,
    /// Whether the pictures' brightness is matched.
    pub match_brightness: bool,
    /// The median filter over the finished map.
    pub median: Median,
}

impl Default for DepthOptions {
    fn default() -> Self {
        Self {
            method: Method::Gram,
            window: Window::Auto,
            align: true,
            match_brightness: true,
            median: Median::None,
        }
    }
}

/// Smallest and largest window, in pixels.
const WINDOWS_PX: std::ops::RangeInclusive<f64> = 1.0..=32.0;

impl DepthOptions {
    /// Every faulty option.
    pub fn faults(&self) -> Vec<Fault> {
        match self.window {
            Window::Px(px) if !WINDOWS_PX.contains(&px) => vec![Fault {
                field: "window",
                message: format!(
                    "must be \"auto\" or from {} to {} px, not {px}",
                    WINDOWS_PX.start(),
                    WINDOWS_PX.end()
                ),
            }],
            _ => Vec::new(),
        }
    }
}
