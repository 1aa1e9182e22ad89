//! Bringing pictures down in size by area: each pixel of the small picture is the mean of the area that it covers in the
//! large one, as in OpenCV's `INTER_AREA`.
//!
//! With k pixels of the large picture for each of the small one, pixel u of the small one stands at (u + 0.5) k − 0.5 of
//! the large one. Rows are summed first, whole rows at a time and in their order, then columns: the order of the sums is
//! that of the source, whatever the processor offers.

use super::Image;

/// The size, width by height, of a picture brought down so that its longer side is `longer_side_px` (1 at least), the
/// other side rounded; `None` if its longer side is not longer than that.
pub(super) fn reduced_size(width: usize, height: usize, longer_side_px: usize) -> Option<(usize, usize)> {
    let (longer, longer_side_px) = (width.max(height), longer_side_px.max(1));
    let side = |length: usize| ((length * longer_side_px + longer / 2) / longer).max(1);
    (longer > longer_side_px && width.min(height) > 0).then(|| (side(width), side(height)))
}

/// Which pixels of a picture each pixel of a smaller one is the mean of.
pub(super) struct Reduction {
    columns: Vec<Span>,
    rows: Vec<Span>,
}

impl Reduction {
    /// From a picture that covers `width` × `height` pixels, of which the last column and the last row may be covered
    /// in part, to one of `to` = (width, height) pixels, at most as many.
    pub(super) fn new(width: f64, height: f64, to: (usize, usize)) -> Reduction {
        Reduction { columns: spans(width, to.0), rows: spans(height, to.1) }
    }

    /// The reduced planes of a picture of `N` planes.
    ///
    /// `add_row(y, weight, sums)` adds row y of the picture, times `weight`, to the sums, one for each of its columns.
    pub(super) fn planes<const N: usize>(
        &self,
        mut add_row: impl FnMut(usize, f32, &mut [[f32; N]]),
    ) -> [Image; N] {
        let (width, height) = (self.columns.len(), self.rows.len());
        let mut planes = [(); N].map(|()| Vec::with_capacity(width * height));
        let mut sums = vec![[0.0; N]; self.columns.last().map_or(0, |span| span.last + 1)];
        for span in &self.rows {
            sums.fill([0.0; N]);
            for y in span.first..=span.last {
                add_row(y, span.weight(y), &mut sums);
            }
            for column in &self.columns {
                let mean = column.mean(&sums);
                planes.iter_mut().zip(mean).for_each(|(plane, level)| plane.push(level));
            }
        }
        planes.map(|pixels| Image::new(width, height, pixels))
    }

    /// The reduced image.
    pub(super) fn image(&self, image: &Image) -> Image {
        let [reduced] = self.planes(|y, weight, sums| {
            sums.as_flattened_mut()
                .iter_mut()
                .zip(image.row(y))
                .for_each(|(sum, level)| *sum += weight * level);
        });
        reduced
    }
}

/// The pixels along one side that one pixel of the smaller picture covers, and what each of them weighs: 1 in all.
struct Span {
    first: usize,
    last: usize,
    first_weight: f32,
    /// The weight of each pixel between the first and the last: these are covered whole.
    inner_weight: f32,
    /// Unused where the first pixel is the last.
    last_weight: f32,
}

impl Span {
    fn weight(&self, at: usize) -> f32 {
        match at {
            _ if at == self.first => self.first_weight,
            _ if at == self.last => self.last_weight,
            _ => self.inner_weight,
        }
    }

    /// The weighted mean of the pixels that are covered.
    fn mean<const N: usize>(&self, row: &[[f32; N]]) -> [f32; N] {
        let [first, rest @ ..] = &row[self.first..=self.last] else { return [0.0; N] };
        let Some((last, inner)) = rest.split_last() else { return *first };
        let mut total = [0.0; N];
        for pixel in inner {
            total.iter_mut().zip(pixel).for_each(|(total, level)| *total += level);
        }
        std::array::from_fn(|n| {
            self.first_weight * first[n] + self.inner_weight * total[n] + self.last_weight * last[n]
        })
    }
}

/// `length` pixels, the last of them perhaps in part, shared among `count` pixels.
fn spans(length: f64, count: usize) -> Vec<Span> {
    let most = length.ceil() as usize - 1;
    (0..count)
        .map(|at| {
            let (from, to) = (length * at as f64 / count as f64, length * (at + 1) as f64 / count as f64);
            let first = (from as usize).min(most);
            let last = (to.ceil() as usize).saturating_sub(1).clamp(first, most);
            let inner_weight = 1.0 / (to - from);
            let first_weight = ((first + 1) as f64).min(to) - from;
            Span {
                first,
                last,
                first_weight: (first_weight * inner_weight) as f32,
                inner_weight: inner_weight as f32,
                last_weight: ((to - last as f64) * inner_weight) as f32,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn reduced(image: &Image, to: (usize, usize)) -> Image {
        Reduction::new(image.width() as f64, image.height() as f64, to).image(image)
    }

    #[test]
    fn a_pixel_is_the_mean_of_what_it_covers() {
        let image = Image::new(3, 2, vec![1.0, 2.0, 3.0, 5.0, 6.0, 7.0]);
        // 1.5 columns for each: the middle column counts half for either side
        let expected = [(1.0 + 5.0 + 0.5 * (2.0 + 6.0)) / 3.0, (3.0 + 7.0 + 0.5 * (2.0 + 6.0)) / 3.0];
        let small = reduced(&image, (2, 1));
        assert!(
            small.pixels().iter().zip(expected).all(|(v, e): (&f32, f32)| (v - e).abs() < 1e-5),
            "{small:?}"
        );
        assert_eq!(reduced(&image, (3, 2)), image);
    }

    #[test]
    fn the_part_of_a_pixel_that_is_covered_counts() {
        let image = Image::new(3, 1, vec![1.0, 2.0, 8.0]);
        let small = Reduction::new(2.5, 1.0, (1, 1)).image(&image);
        assert!((small.at(0, 0) - (1.0 + 2.0 + 4.0) / 2.5).abs() < 1e-5, "{small:?}");
    }

    #[test]
    fn a_ramp_stays_a_ramp_at_its_place() {
        for (width, height, longer) in
            [(640, 480, 320), (900, 600, 300), (1000, 333, 640), (333, 1000, 501), (97, 41, 96)]
        {
            let ramp = Image::from_fn(width, height, |x, y| 0.125 * x as f32 + 0.25 * y as f32);
            let (w, h) = reduced_size(width, height, longer).unwrap();
            let (kx, ky) = (width as f32 / w as f32, height as f32 / h as f32);
            let small = reduced(&ramp, (w, h));
            // A pixel that is shared counts at its centre, not at that of its part: up to 1/8 px for either end.
            let off = |k: f32| if k.fract() == 0.0 { 0.0 } else { 0.25 / k };
            let most = 0.125 * off(kx) + 0.25 * off(ky) + 1e-3;
            for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                let expected = 0.125 * ((x as f32 + 0.5) * kx - 0.5) + 0.25 * ((y as f32 + 0.5) * ky - 0.5);
                assert!(
                    (small.at(x, y) - expected).abs() < most,
                    "({x}, {y}): {} {expected}",
                    small.at(x, y)
                );
            }
        }
    }

    #[test]
    fn the_longer_side_is_met_and_the_other_one_rounded() {
        assert_eq!(reduced_size(4000, 3000, 640), Some((640, 480)));
        assert_eq!(reduced_size(3000, 4000, 640), Some((480, 640)));
        assert_eq!(reduced_size(1001, 333, 500), Some((500, 166)));
        assert_eq!(reduced_size(1001, 335, 500), Some((500, 167)));
        assert_eq!(reduced_size(8000, 1, 100), Some((100, 1)));
        assert_eq!(reduced_size(2, 2, 0), Some((1, 1)));
        assert_eq!(reduced_size(640, 480, 640), None);
        assert_eq!(reduced_size(0, 0, 0), None);
    }

    proptest! {
        #[test]
        fn the_mean_is_kept_and_what_is_even_stays_even(
            width in 1usize..70, height in 1usize..70, longer in 1usize..70, seed in any::<u32>(),
        ) {
            let Some(to) = reduced_size(width, height, longer) else { return Ok(()) };
            prop_assert_eq!(to.0.max(to.1), longer);
            let image = Image::from_fn(width, height, |x, y| {
                ((x as u32 * 7919 + y as u32 * 104_729).wrapping_mul(seed | 1) >> 24) as f32
            });
            let small = reduced(&image, to);
            prop_assert!((small.mean() - image.mean()).abs() < 1e-2, "{} {}", small.mean(), image.mean());
            let even = reduced(&Image::from_fn(width, height, |_, _| 200.0), to);
            prop_assert!(even.pixels().iter().all(|v| (v - 200.0).abs() < 1e-3), "{even:?}");
        }
    }
}
