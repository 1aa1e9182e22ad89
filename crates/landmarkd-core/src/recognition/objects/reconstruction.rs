//! The reconstruction of a picture from its eigenpoint (the inverse of B(13)): the appearance, the sum of eigenimages,
//! and the residual.

use super::appearance::{Appearance, SizeMismatch};
use super::model::Objects;
use crate::imaging::{Frame, Image};

/// A picture and its reconstruction. All three are pictures of samples, of one size, in 0..=255.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// B(7): the normalised picture. Black for a blank one.
    pub appearance: Image,
    /// The mean and the eigenimages, weighted by the eigenpoint; on the scale of `appearance`.
    pub rebuilt: Image,
    /// The difference, on the same scale about mid-gray.
    pub residual: Image,
    /// Length of the residual where the appearance has length one.
    pub distance_from_space: f64,
}

impl Reconstruction {
    /// Rebuild a picture from its eigenpoint.
    ///
    /// # Errors
    /// [`SizeMismatch`] if the picture is of another size and `resize` is `never`.
    pub fn of(frame: &Frame, model: &Objects) -> Result<Reconstruction, SizeMismatch> {
        let Appearance { vector, .. } = model.normaliser.appearance(frame)?; // B(7)
        let (point, distance_from_space) = model.universal.locate(&vector); // B(13)
        let rebuilt = model.universal.rebuild(&point); // B(13): c + Eᵀh
        let brightest = vector.iter().fold(f32::MIN_POSITIVE, |most, &v| most.max(v));
        let gray = |v: &f32| (255.0 * v / brightest).clamp(0.0, 255.0);
        let differences = vector.iter().zip(&rebuilt).map(|(given, rebuilt)| given - rebuilt);
        let residual = differences.map(|v| (127.5 * (1.0 + v / brightest)).clamp(0.0, 255.0));
        Ok(Reconstruction {
            residual: model.normaliser.picture(residual, 127.5),
            appearance: model.normaliser.picture(vector.iter().map(gray), 0.0),
            rebuilt: model.normaliser.picture(rebuilt.iter().map(gray), 0.0),
            distance_from_space,
        })
    }

    /// The three beside each other, in their order, each sample a square of so many pixels that a person sees it.
    pub fn side_by_side(&self) -> Image {
        /// Least length of the longer side of one of them.
        const MIN_SIDE_PX: usize = 160;
        let three = [&self.appearance, &self.rebuilt, &self.residual];
        let (width, height) = (self.appearance.width(), self.appearance.height());
        let step_px = MIN_SIDE_PX.div_ceil(width.max(height));
        Image::from_fn(3 * width * step_px, height * step_px, |x, y| {
            let column = x / step_px;
            three[column / width].at(column % width, y / step_px)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_pictures::{SIDE_PX, normaliser, thing, turntable};
    use super::super::{AppearanceOf, Dimension, ObjectOptions, train};
    use super::*;

    /// Three things, in nearly as many dimensions as there are views.
    fn trained() -> Objects {
        let options =
            ObjectOptions { dimension: Dimension::Fixed(50), ..ObjectOptions::of(AppearanceOf::Intensity) };
        train(turntable(3, 20, &options), &normaliser(&options), &options).unwrap().0
    }

    fn squares(image: &Image) -> f64 {
        image.pixels().iter().map(|&v| f64::from(v - 127.5).powi(2)).sum()
    }

    #[test]
    fn a_known_view_is_rebuilt_and_a_strange_one_leaves_a_residual() {
        let model = trained();
        let known = Reconstruction::of(&thing(1, 40.0), &model).unwrap();
        let strange = Reconstruction::of(&thing(9, 40.0), &model).unwrap();
        let (near, far) = (known.distance_from_space, strange.distance_from_space);
        assert!(near < 0.1 && far > 0.3, "{near} and {far}");
        assert!(squares(&strange.residual) > 4.0 * squares(&known.residual));
    }

    #[test]
    fn the_residual_is_as_long_as_the_distance_from_the_space() {
        let seen = Reconstruction::of(&thing(9, 40.0), &trained()).unwrap();
        // On the scale of the pictures: 127.5 gray levels of the residual are 255 of the appearance.
        let length = 4.0 * squares(&seen.residual);
        let whole: f64 = seen.appearance.pixels().iter().map(|&v| f64::from(v).powi(2)).sum();
        assert!(((length / whole).sqrt() - seen.distance_from_space).abs() < 1e-3);
    }

    #[test]
    fn a_blank_picture_has_a_black_appearance() {
        let blank = Frame::gray(Image::from_fn(SIDE_PX, SIDE_PX, |_, _| 0.0));
        let seen = Reconstruction::of(&blank, &trained()).unwrap();
        assert!(seen.appearance.pixels().iter().all(|&v| v == 0.0));
    }

    #[test]
    fn the_three_stand_beside_each_other_and_large_enough() {
        let seen = Reconstruction::of(&thing(0, 0.0), &trained()).unwrap();
        let (width, height) = (seen.appearance.width(), seen.appearance.height());
        let together = seen.side_by_side();
        let step_px = together.width() / (3 * width);
        assert!(width * step_px >= 160 && together.height() == height * step_px);
        assert_eq!(together.at(step_px * (width + 3), step_px * 2), seen.rebuilt.at(3, 2));
        assert_eq!(
            together.at(together.width() - 1, together.height() - 1),
            seen.residual.at(width - 1, height - 1)
        );
    }
}
