//! The options of a segmentation.

use crate::vision::OptionFault;

/// What a pixel is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// The mean of the background around it, and an offset.
    Adaptive,
    /// One level for the picture, which tells two classes of pixels best apart (Otsu).
    Otsu,
    /// This level, 0..=255.
    Fixed(f64),
}

/// What objects look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polarity {
    /// Objects are lighter than the background, darker, or of another colour.
    Either,
    /// Objects are lighter than the background.
    LightOnDark,
    /// Objects are darker than the background.
    DarkOnLight,
}

/// All options of a segmentation.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentationOptions {
    /// What separates objects from the background.
    pub threshold: Threshold,
    /// Adaptive only: side of the square that the background is estimated in, 3..=4095 px; `None`: a third of the
    /// picture's shorter side, or all of it where one object fills the picture.
    pub window_px: Option<usize>,
    /// Adaptive only: least difference of a pixel from the background, 0..=255 gray levels; `None`: 3.5 standard deviations of
    /// the background, a twenty-fifth of the picture's range at least.
    pub offset: Option<f64>,
    /// Whether objects are light or dark. Colour counts with [`Polarity::Either`] alone.
    pub polarity: Polarity,
    /// Smaller regions are specks, from 1; `None`: what noise hardly reaches, 12 at least; with one level a
    /// 500th of the picture, at least 16.
    pub min_area_px: Option<usize>,
    /// Most regions in the result, the largest, 1..=1000.
    pub max_objects: usize,
}

/// Most regions that may be asked for.
pub const MAX_OBJECTS: usize = 1000;
/// Largest side of the window.
pub(super) const MAX_WINDOW_PX: usize = 4095;

impl SegmentationOptions {
    /// Everything that is wrong with the options, all at once; empty if they can be used.
    pub fn faults(&self) -> Vec<OptionFault> {
        let mut faults = Vec::new();
        let mut fault = |option, message| faults.push(OptionFault { option, message });
        if let Threshold::Fixed(level) = self.threshold
            && !(0.0..=255.0).contains(&level)
        {
            fault("threshold", format!("{level} is not in 0..=255, nor adaptive or otsu"));
        }
        if let Some(window_px) = self.window_px.filter(|window_px| !(3..=MAX_WINDOW_PX).contains(window_px)) {
            fault("window_px", format!("{window_px} is not in 3..={MAX_WINDOW_PX}"));
        }
        if let Some(offset) = self.offset.filter(|offset| !(0.0..=255.0).contains(offset)) {
            fault("offset", format!("{offset} is not in 0..=255"));
        }
        if self.min_area_px == Some(0) {
            fault("min_area_px", "0 is too small: 1 is the least".to_owned());
        }
        if !(1..=MAX_OBJECTS).contains(&self.max_objects) {
            fault("max_objects", format!("{} is not in 1..={MAX_OBJECTS}", self.max_objects));
        }
        faults
    }
}

impl Default for SegmentationOptions {
    fn default() -> Self {
        SegmentationOptions {
            threshold: Threshold::Adaptive,
            window_px: None,
            offset: None,
            polarity: Polarity::Either,
            min_area_px: None,
            max_objects: 100,
        }
    }
}
