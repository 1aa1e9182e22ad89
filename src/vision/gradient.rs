//! The gradient, grey levels per pixel: Sobel's operator over 8, with mirror borders.

use super::smoothing::mirrored;
use crate::imaging::Image;

/// The two components of the gradient; x right, y down.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// ∂/∂x.
    pub x: Image,
    /// ∂/∂y.
    pub y: Image,
}

/// The gradient of an image: differences of the two neighbours, averaged 1 2 1 across.
pub fn gradient(image: &Image) -> Gradient {
    let (width, height) = (image.width(), image.height());
    let mut x = vec![0.0; width * height];
    let mut y = vec![0.0; width * height];
    // the sum and the difference down each column, with one mirrored column on either side
    let mut sum = vec![0.0; width + 2];
    let mut difference = vec![0.0; width + 2];
    for row in 0..if width == 0 { 0 } else { height } {
        let above = image.row(mirrored(row as isize - 1, height));
        let below = image.row(mirrored(row as isize + 1, height));
        let (out_x, out_y) = (&mut x[row * width..][..width], &mut y[row * width..][..width]);
        pulp::Arch::new().dispatch(|| {
            down(above, image.row(row), below, &mut sum[1..=width], &mut difference[1..=width]);
            for padded in [&mut sum, &mut difference] {
                padded[0] = padded[1 + mirrored(-1, width)];
                padded[width + 1] = padded[1 + mirrored(width as isize, width)];
            }
            across(&sum, &difference, out_x, out_y);
        });
    }
    Gradient { x: Image::new(width, height, x), y: Image::new(width, height, y) }
}

#[inline(always)]
fn down(above: &[f32], here: &[f32], below: &[f32], sum: &mut [f32], difference: &mut [f32]) {
    for ((((above, here), below), sum), difference) in
        above.iter().zip(here).zip(below).zip(sum).zip(difference)
    {
        *sum = (above + below) + 2.0 * here;
        *difference = below - above;
    }
}

#[inline(always)]
fn across(sum: &[f32], difference: &[f32], out_x: &mut [f32], out_y: &mut [f32]) {
    let width = out_x.len();
    for ((out, left), right) in out_x.iter_mut().zip(&sum[..width]).zip(&sum[2..]) {
        *out = (right - left) * 0.125;
    }
    let neighbours = difference[..width].iter().zip(&difference[1..]).zip(&difference[2..]);
    for (out, ((left, here), right)) in out_y.iter_mut().zip(neighbours) {
        *out = ((left + right) + 2.0 * here) * 0.125;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_has_its_slope() {
        let ramp = Image::from_fn(8, 6, |x, y| 3.0 * x as f32 - 2.0 * y as f32);
        let gradient = gradient(&ramp);
        for y in 1..5 {
            for x in 1..7 {
                assert_eq!((gradient.x.at(x, y), gradient.y.at(x, y)), (3.0, -2.0), "({x}, {y})");
            }
        }
    }

    #[test]
    fn at_a_mirror_there_is_no_slope_across_it() {
        let gradient = gradient(&Image::from_fn(5, 5, |x, y| (x * x + 7 * y) as f32));
        assert!((0..5).all(|i| gradient.x.at(0, i) == 0.0 && gradient.y.at(i, 4) == 0.0));
    }

    #[test]
    fn one_pixel_has_no_gradient() {
        let gradient = gradient(&Image::new(1, 1, vec![9.0]));
        assert_eq!((gradient.x.pixels(), gradient.y.pixels()), (&[0.0][..], &[0.0][..]));
    }
}
