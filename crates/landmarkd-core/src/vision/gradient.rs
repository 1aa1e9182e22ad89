//! The gradient, gray levels per pixel: Sobel's operator over 8, with mirror borders.

use pulp::{Arch, Simd, WithSimd};

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
    let mut rows = GradientRows::new(width);
    let [mut x, mut y] = [(); 2].map(|()| vec![0.0; width * height]);
    if width > 0 {
        for (row, (x, y)) in x.chunks_exact_mut(width).zip(y.chunks_exact_mut(width)).enumerate() {
            rows.write(image, row, x, y);
        }
    }
    Gradient { x: Image::new(width, height, x), y: Image::new(width, height, y) }
}

/// The gradient at one pixel, ∂/∂x and ∂/∂y: bit for bit that of [`gradient`].
pub fn gradient_at(image: &Image, x: usize, y: usize) -> [f32; 2] {
    let rows = [-1, 0, 1].map(|off| image.row(mirrored(y as isize + off, image.height())));
    let down = [-1, 0, 1].map(|off| {
        let column = mirrored(x as isize + off, image.width());
        let [above, here, below] = rows.map(|row| row[column]);
        ((above + below) + 2.0 * here, below - above)
    });
    let [left, here, right] = down;
    [(right.0 - left.0) * 0.125, ((left.1 + right.1) + 2.0 * here.1) * 0.125]
}

/// The gradient as pairs (∂/∂x, ∂/∂y), its border continued: what samples sub-windows finds both in one place, and
/// beyond the border what is on it.
#[derive(Clone, Debug)]
pub struct PaddedGradient {
    width: usize,
    height: usize,
    border_px: usize,
    /// (height + 2 · border) rows of width + 2 · border pairs.
    pairs: Vec<[f32; 2]>,
}

impl PaddedGradient {
    /// The gradient of an image, and `border_px` more pixels to each side.
    pub fn new(image: &Image, border_px: usize) -> PaddedGradient {
        let (width, height) = (image.width(), image.height());
        let stride = width + 2 * border_px;
        if width == 0 || height == 0 {
            return PaddedGradient { width, height, border_px, pairs: Vec::new() };
        }
        let mut pairs = Vec::with_capacity(stride * (height + 2 * border_px));
        let mut rows = GradientRows::new(width);
        let (mut x, mut y) = (vec![0.0; width], vec![0.0; width]);
        for row in 0..height {
            rows.write(image, row, &mut x, &mut y);
            let (first, last) = ([x[0], y[0]], [x[width - 1], y[width - 1]]);
            pairs.extend(std::iter::repeat_n(first, border_px));
            pairs.extend(x.iter().zip(&y).map(|(x, y)| [*x, *y]));
            pairs.extend(std::iter::repeat_n(last, border_px));
            if row == 0 {
                (0..border_px).for_each(|_| pairs.extend_from_within(..stride));
            }
        }
        let last = pairs.len() - stride;
        (0..border_px).for_each(|_| pairs.extend_from_within(last..last + stride));
        PaddedGradient { width, height, border_px, pairs }
    }

    /// Width of the image, px.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height of the image, px.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels beyond each border.
    pub fn border_px(&self) -> usize {
        self.border_px
    }

    /// Pairs from one row to the next.
    pub(super) fn stride(&self) -> usize {
        self.width + 2 * self.border_px
    }

    /// All pairs: that of pixel (x, y) is at (y + border) · stride + x + border.
    pub(super) fn pairs(&self) -> &[[f32; 2]] {
        &self.pairs
    }
}

/// The gradient row by row.
pub(super) struct GradientRows {
    /// Sum and difference down each column, with one mirrored column on either side.
    sum: Vec<f32>,
    difference: Vec<f32>,
}

impl GradientRows {
    pub fn new(width: usize) -> GradientRows {
        GradientRows { sum: vec![0.0; width + 2], difference: vec![0.0; width + 2] }
    }

    /// Writes the gradient along row `row` of the image, which is as wide as this was made for.
    pub fn write(&mut self, image: &Image, row: usize, out_x: &mut [f32], out_y: &mut [f32]) {
        let (width, height) = (image.width(), image.height());
        let GradientRows { sum, difference } = self;
        Arch::new().dispatch(Down {
            above: image.row(mirrored(row as isize - 1, height)),
            here: image.row(row),
            below: image.row(mirrored(row as isize + 1, height)),
            sum: &mut sum[1..=width],
            difference: &mut difference[1..=width],
        });
        for padded in [&mut *sum, &mut *difference] {
            padded[0] = padded[1 + mirrored(-1, width)];
            padded[width + 1] = padded[1 + mirrored(width as isize, width)];
        }
        Arch::new().dispatch(Across { sum, difference, out_x, out_y });
    }
}

/// One row: 1 2 1 down each column, and the difference of the two rows about it.
struct Down<'a> {
    above: &'a [f32],
    here: &'a [f32],
    below: &'a [f32],
    sum: &'a mut [f32],
    difference: &'a mut [f32],
}

impl WithSimd for Down<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let rows = self.above.iter().zip(self.here).zip(self.below);
        for (((above, here), below), (sum, difference)) in rows.zip(self.sum.iter_mut().zip(self.difference))
        {
            *sum = (above + below) + 2.0 * here;
            *difference = below - above;
        }
    }
}

/// One row: the difference of the two columns about each pixel, and 1 2 1 across the rows' difference.
struct Across<'a> {
    sum: &'a [f32],
    difference: &'a [f32],
    out_x: &'a mut [f32],
    out_y: &'a mut [f32],
}

impl WithSimd for Across<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for ((out, left), right) in self.out_x.iter_mut().zip(self.sum).zip(&self.sum[2..]) {
            *out = (right - left) * 0.125;
        }
        let difference = self.difference;
        let neighbours = difference.iter().zip(&difference[1..]).zip(&difference[2..]);
        for (out, ((left, here), right)) in self.out_y.iter_mut().zip(neighbours) {
            *out = ((left + right) + 2.0 * here) * 0.125;
        }
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
    fn at_one_pixel_it_is_that_of_the_picture() {
        for (width, height) in [(1, 1), (2, 1), (1, 3), (7, 5)] {
            let picture =
                Image::from_fn(width, height, |x, y| ((x * x * 7 + y * 31 + x * y) % 51) as f32 / 3.0);
            let whole = gradient(&picture);
            for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                assert_eq!(gradient_at(&picture, x, y), [whole.x.at(x, y), whole.y.at(x, y)]);
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
