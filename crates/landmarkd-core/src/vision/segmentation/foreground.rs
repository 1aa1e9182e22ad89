//! The foreground: by the mean of the background around each pixel, or by Otsu's level.
//!
//! The background is estimated in three rounds. The mean around a pixel separates a lower class; that class's mean, what
//! is near the background; and the mean of that is the background. So bright parts don't lift
//! the background around them, and a part needn't be smaller than half the window to be whole. The text takes the mean
//! alone.

use super::SegmentationOptions;
use super::background::Background;

/// The least offset, in gray levels.
const LEAST_OFFSET: f32 = 10.0;
/// The largest offset that is chosen automatically.
const MOST_OFFSET: f32 = 60.0;
/// The chosen offset in standard deviations of the background.
const OFFSET_SIGMAS: f32 = 4.0;
/// The window is the picture's shorter side by this, if it is chosen.
const WINDOWS_A_SIDE: usize = 3;
/// One row in so many counts for the deviation of the background.
const EVERY_ROW: usize = 4;
/// From a median absolute deviation to a standard deviation.
const SIGMAS_A_DEVIATION: f32 = 1.4826;
/// Steps of deviations in gray levels, and how many there are.
const DEVIATION_STEP: f32 = 0.125;
const DEVIATION_STEPS: usize = 1024;

/// A picture over its background.
pub(super) struct Foreground {
    /// By how much each pixel is brighter than its background, in gray levels, row-major.
    pub above: Vec<f32>,
    /// By how much it must be.
    pub offset: f32,
}

impl Foreground {
    /// Of a picture of light objects, `width` pixels a row, by its background.
    pub fn of(levels: &[f32], width: usize, options: &SegmentationOptions) -> Foreground {
        let height = levels.len() / width.max(1);
        let side = options.window_px.unwrap_or(width.min(height) / WINDOWS_A_SIDE);
        let near = options.offset.map_or(LEAST_OFFSET, |offset| offset as f32);
        let mut background = Background::new(width, height, side); // B§3
        let mut ground = vec![f32::INFINITY; levels.len()];
        for offset in [0.0, 0.0, near] {
            background.update(levels, &ground, offset);
            background.interpolate(&mut ground);
        }
        let mut above = ground;
        above.iter_mut().zip(levels).for_each(|(above, v)| *above = v - *above);
        let offset = match options.offset {
            Some(offset) => offset as f32,
            None => (OFFSET_SIGMAS * deviation(&above, width)).clamp(LEAST_OFFSET, MOST_OFFSET),
        };
        Foreground { above, offset }
    }
}

/// Otsu's level: the one between two classes of gray levels whose means are farthest apart, by their variance.
/// "At most" is background. Pictures of one level have none that is above it.
pub(super) fn otsu_level(levels: &[f32]) -> f32 {
    let mut counts = [0_usize; 256];
    for level in levels {
        counts[(level + 0.5).clamp(0.0, 255.0) as usize] += 1;
    }
    let all = levels.len() as f64;
    let sum: f64 = counts.iter().enumerate().map(|(level, &count)| level as f64 * count as f64).sum();
    let (mut below, mut below_sum) = (0.0, 0.0);
    let (mut best, mut best_level) = (0.0, 255);
    for (level, &count) in counts.iter().enumerate() {
        below += count as f64;
        below_sum += level as f64 * count as f64;
        let above = all - below;
        if below > 0.0 && above > 0.0 {
            let apart = below_sum / below - (sum - below_sum) / above;
            let between = below * above * apart.powi(2);
            if between > best {
                (best, best_level) = (between, level);
            }
        }
    }
    // Levels were rounded to be counted.
    best_level as f32 + 0.5
}

/// Standard deviation of the background, by the median absolute deviation in every [`EVERY_ROW`]th row.
fn deviation(above: &[f32], width: usize) -> f32 {
    let mut counts = [0_usize; DEVIATION_STEPS];
    for row in above.chunks_exact(width.max(1)).step_by(EVERY_ROW) {
        for v in row.iter().filter(|&&v| v <= LEAST_OFFSET) {
            counts[((v.abs() / DEVIATION_STEP) as usize).min(DEVIATION_STEPS - 1)] += 1;
        }
    }
    let half = counts.iter().sum::<usize>() / 2;
    let mut seen = 0;
    let median = counts.iter().position(|count| {
        seen += count;
        seen > half
    });
    median.map_or(0.0, |step| SIGMAS_A_DEVIATION * (step as f32 + 0.5) * DEVIATION_STEP)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(x: usize, y: usize) -> f32 {
        20.0 + ((x * 7 + y * 13) % 5) as f32
    }

    #[test]
    fn bright_parts_do_not_lift_the_background_around_them() {
        let (width, height) = (120, 90);
        let part = |x: usize, y: usize| (40..70).contains(&x) && (30..60).contains(&y);
        let levels: Vec<f32> = (0..width * height)
            .map(|at| (at % width, at / width))
            .map(|(x, y)| if part(x, y) { 220.0 } else { table(x, y) })
            .collect();
        let foreground = Foreground::of(&levels, width, &SegmentationOptions::default());
        for (at, &above) in foreground.above.iter().enumerate() {
            let (x, y) = (at % width, at / width);
            assert_eq!(above > foreground.offset, part(x, y), "({x}, {y}): {above}");
            assert!(part(x, y) || above.abs() < 4.0, "({x}, {y}): {above}");
        }
    }

    #[test]
    fn the_offset_follows_the_noise_of_the_background() {
        let uneven =
            |step: f32| -> Vec<f32> { (0..10_000).map(|at| 60.0 + step * ((at * 31) % 11) as f32).collect() };
        let offset = |step| Foreground::of(&uneven(step), 100, &SegmentationOptions::default()).offset;
        assert_eq!(offset(0.1), LEAST_OFFSET);
        assert!(offset(2.0) > 1.5 * LEAST_OFFSET, "{}", offset(2.0));
        let stated = SegmentationOptions { offset: Some(33.0), ..SegmentationOptions::default() };
        assert_eq!(Foreground::of(&uneven(2.0), 100, &stated).offset, 33.0);
    }

    #[test]
    fn otsus_level_lies_between_two_classes() {
        let levels: Vec<f32> =
            (0..1000).map(|at| if at % 4 == 0 { 180.0 } else { 30.0 } + (at % 9) as f32).collect();
        let level = otsu_level(&levels);
        assert!((38.0..180.0).contains(&level), "{level}");
        assert_eq!(levels.iter().filter(|&&v| v > level).count(), 250);
        assert_eq!(otsu_level(&[7.0; 50]), 255.5, "one level has nothing above it");
    }
}
