//! The ground (B§3): level and noise of the background about each pixel, estimated from both sides, so that neither
//! lighter nor darker parts pull it.
//!
//! First by blocks: the ground is what changes smoothly from block to block and has most of the picture and of its
//! border; a quadratic surface through it also says what is beneath a part larger than any window. Then, in a window
//! about each block, the mean of what is near that surface corrects it; last, the same by pixels, with their standard
//! deviation. Where one object may fill most of the picture, the ground is what most of its border shows, and of that the
//! corners count most, whether or not these are connected.

use super::Scene;
use super::blocks::Blocks;
use super::options::Polarity;
use crate::statistics::quantile_nearest;

/// Blocks so far apart are compared, so that ground on both sides of a thin part is one.
const REACHES: [usize; 3] = [1, 2, 4];
/// Neighbouring blocks are one surface if they differ by at most a part of the range and so many times what neighbours
/// commonly differ by: the first factor for which the surface is even, that is, quadratic within the last part of the range.
const SMOOTH_PART: f32 = 0.01;
const SMOOTH_DEVIATIONS: [f32; 5] = [4.0, 2.8, 2.0, 1.4, 1.0];
const UNEVEN_PART: f32 = 0.1;
/// What the border shows counts so many times what the area shows.
const BORDER_WEIGHT: f32 = 2.0;
/// Surfaces at the border of one object's picture are one ground if their means differ by at most this part of the range.
const SAME_PART: f32 = 0.04;
/// Blocks within so many standard deviations of the surface are ground.
const BLOCK_DEVIATIONS: f32 = 3.5;
/// Pixels within so many are; the standard deviation of what is left of a normal distribution is that part of it.
const PIXEL_DEVIATIONS: f32 = 3.0;
const TRIMMED_PART: f32 = 0.9866;
/// Deviations below this part of the range aren't told from it.
const LEAST_PART: f32 = 0.004;
/// Rounds of fitting the surface, and of correcting it in windows.
const SURFACE_ROUNDS: usize = 3;
const WINDOW_ROUNDS: usize = 2;
/// Below this part of a window, ground isn't enough to know its mean.
const LEAST_GROUND: f32 = 0.02;
/// One row in so many counts for the last correction; one pixel in so many rows and columns for a deviation.
const EVERY_ROW: usize = 2;
const EVERY_PIXEL: [usize; 2] = [4, 3];
/// Part of a normal distribution within one standard deviation. Of levels of a coarse step the median is too often 0.
const WITHIN_SIGMA: f64 = 0.683;
/// That part of neighbouring blocks at least is ground, and the quantile of a normal distribution's absolute value.
const GROUND_NEIGHBOURS: f64 = 0.25;
const GROUND_NEIGHBOURS_SIGMAS: f32 = 0.319;
/// The range is between these parts of the picture's pixels.
const RANGE_PART: f64 = 0.001;
/// A term of the surface of which a smaller part is orthogonal to those before it isn't determined by the ground: of a
/// square in a picture that is all ground it is 0.44, in one whose corners alone are ground next to nothing.
const LEAST_REST: f64 = 0.05;

/// The ground of a picture of one or several planes.
pub(super) struct Ground {
    pub blocks: Blocks,
    /// Plane by plane.
    pub surfaces: Vec<Surface>,
    /// Whether a block is ground.
    pub is_ground: Vec<bool>,
    /// From the darkest pixels to the lightest, of the plane where they are farthest apart.
    pub range: f32,
}

/// The ground of one plane.
pub(super) struct Surface {
    /// The ground's level in each block.
    pub levels: Vec<f32>,
    /// The standard deviation of its pixels about each block.
    pub deviations: Vec<f32>,
    /// Of all its pixels.
    pub deviation: f32,
    /// That of the means of its blocks.
    pub block_deviation: f32,
}

impl Ground {
    /// Of planes of `width` pixels a row, the first one the luminance, corrected in windows of `window` pixels.
    pub fn of(planes: &[&[f32]], width: usize, window: usize, polarity: Polarity, scene: Scene) -> Ground {
        let height = planes[0].len() / width.max(1);
        let blocks = Blocks::new(width, height);
        let means: Vec<Vec<f32>> = planes.iter().map(|plane| blocks.means(plane)).collect();
        let range = planes.iter().map(|plane| range(plane, width)).fold(0.0, f32::max);
        let mut is_ground = vec![];
        for deviations in SMOOTH_DEVIATIONS {
            let surfaces = SmoothSurfaces::of(&blocks, &means, range, deviations, scene);
            is_ground = surfaces.ground(&blocks, &means, range, polarity, scene);
            let is_even = means.iter().all(|means| {
                let surface = quadratic(&blocks, means, &is_ground);
                let residuals: Vec<f32> =
                    means.iter().zip(surface).map(|(mean, level)| mean - level).collect();
                deviation(&residuals, &is_ground) <= UNEVEN_PART * range
            });
            if is_even {
                break;
            }
        }
        let mut residuals = means.clone();
        let mut tolerances = vec![0.0; planes.len()];
        for round in 0..SURFACE_ROUNDS + WINDOW_ROUNDS {
            for ((residuals, means), tolerance) in residuals.iter_mut().zip(&means).zip(&mut tolerances) {
                *residuals = if round < SURFACE_ROUNDS {
                    let surface = quadratic(&blocks, means, &is_ground);
                    means.iter().zip(surface).map(|(mean, level)| mean - level).collect()
                } else {
                    let weights: Vec<f32> = is_ground.iter().map(|&is| f32::from(u8::from(is))).collect();
                    let kept: Vec<f32> =
                        residuals.iter().zip(&weights).map(|(v, weight)| v * weight).collect();
                    let means = windowed(&blocks, window, &kept, &weights, 1.0);
                    residuals.iter().zip(means).map(|(v, mean)| v - mean.unwrap_or(0.0)).collect()
                };
                *tolerance = deviation(residuals, &is_ground).max(LEAST_PART * range);
            }
            let is_near = |block: usize| {
                residuals.iter().zip(&tolerances).all(|(v, sigma)| v[block].abs() <= BLOCK_DEVIATIONS * sigma)
            };
            is_ground = (0..blocks.count()).map(is_near).collect();
        }
        let surfaces = (planes.iter().zip(&means).zip(&residuals).zip(&tolerances))
            .map(|(((plane, means), residuals), &block_deviation)| {
                let levels = means.iter().zip(residuals).map(|(mean, v)| mean - v).collect();
                Surface::of(plane, width, window, &blocks, &is_ground, levels, block_deviation, range)
            })
            .collect();
        Ground { blocks, surfaces, is_ground, range }
    }

    /// By how much each pixel of a plane is above its ground.
    pub fn differences(&self, plane: &[f32], levels: &[f32]) -> Vec<f32> {
        differences(&self.blocks, plane, levels)
    }

    /// The standard deviation of the ground's pixels, by their absolute values.
    pub fn deviation(&self, differences: &[f32], width: usize) -> f32 {
        pixel_deviation(&self.blocks, &self.is_ground, differences, width)
    }
}

impl Surface {
    #[expect(clippy::too_many_arguments, reason = "one step of Ground::of")]
    fn of(
        plane: &[f32],
        width: usize,
        window: usize,
        blocks: &Blocks,
        is_ground: &[bool],
        mut levels: Vec<f32>,
        block_deviation: f32,
        range: f32,
    ) -> Surface {
        let above = differences(blocks, plane, &levels);
        let deviation = pixel_deviation(blocks, is_ground, &above, width);
        let most = PIXEL_DEVIATIONS * deviation.max(LEAST_PART * range);
        let sums = blocks.sums(&above, most, EVERY_ROW);
        let area = (blocks.side * blocks.side.div_ceil(EVERY_ROW)) as f32;
        let mean = windowed(blocks, window, &sums.values, &sums.pixels, area);
        let square = windowed(blocks, window, &sums.squares, &sums.pixels, area);
        let deviations = (levels.iter_mut().zip(mean).zip(square))
            .map(|((level, mean), square)| {
                let (Some(mean), Some(square)) = (mean, square) else { return deviation };
                *level += mean;
                (square - mean * mean).max(0.0).sqrt() / TRIMMED_PART
            })
            .collect();
        Surface { levels, deviations, deviation, block_deviation }
    }
}

fn differences(blocks: &Blocks, plane: &[f32], levels: &[f32]) -> Vec<f32> {
    let mut out = Vec::with_capacity(plane.len());
    blocks.interpolate(levels, |y, ground| {
        let row = &plane[y * ground.len()..][..ground.len()];
        out.extend(row.iter().zip(ground).map(|(v, ground)| v - ground));
    });
    out
}

/// By a sample of the ground's pixels.
fn pixel_deviation(blocks: &Blocks, is_ground: &[bool], differences: &[f32], width: usize) -> f32 {
    let [rows, columns] = EVERY_PIXEL;
    let mut sample = Vec::new();
    for (y, row) in differences.chunks_exact(width.max(1)).enumerate().step_by(rows) {
        let is_ground = &is_ground[y / blocks.side * blocks.columns..];
        // Not always the same column of a block.
        let pixels = row.iter().enumerate().skip(y / rows % columns).step_by(columns);
        sample.extend(pixels.filter(|(x, _)| is_ground[x / blocks.side]).map(|(_, v)| v.abs()));
    }
    quantile_nearest(&mut sample, WITHIN_SIGMA, f32::total_cmp).unwrap_or(0.0)
}

/// From the darkest pixels of a sample to the lightest.
fn range(plane: &[f32], width: usize) -> f32 {
    let [rows, columns] = EVERY_PIXEL;
    let rows = plane.chunks_exact(width.max(1)).enumerate().step_by(rows);
    let mut sample: Vec<f32> =
        rows.flat_map(|(y, row)| row.iter().copied().skip(y % columns).step_by(columns)).collect();
    let mut level = |part: f64| quantile_nearest(&mut sample, part, f32::total_cmp).unwrap_or(0.0);
    level(1.0 - RANGE_PART) - level(RANGE_PART)
}

/// The standard deviation of the values of ground blocks, by their absolute values.
fn deviation(values: &[f32], is_ground: &[bool]) -> f32 {
    let mut sample: Vec<f32> =
        values.iter().zip(is_ground).filter(|(_, is_ground)| **is_ground).map(|(v, _)| v.abs()).collect();
    quantile_nearest(&mut sample, WITHIN_SIGMA, f32::total_cmp).unwrap_or(0.0)
}

/// The mean of each block's window: sums by weights, where these are enough; `whole` is the weight of a block.
fn windowed(blocks: &Blocks, window: usize, sums: &[f32], weights: &[f32], whole: f32) -> Vec<Option<f32>> {
    let (sums, weights) = (blocks.window_sums(sums, window), blocks.window_sums(weights, window));
    let most = whole * ((window / blocks.side).max(1) as f32).powi(2);
    let mean = |(sum, weight): (f32, f32)| (weight > LEAST_GROUND * most).then(|| sum / weight);
    sums.into_iter().zip(weights).map(mean).collect()
}

/// The blocks of a picture divided into surfaces within which neighbours differ little.
struct SmoothSurfaces {
    /// By block: the number of its surface.
    of_block: Vec<usize>,
    surfaces: Vec<SmoothSurface>,
}

/// See [`SmoothSurfaces`].
#[derive(Default)]
struct SmoothSurface {
    blocks: f32,
    border_blocks: f32,
    /// The sum of |x·y| over its blocks at the border: of those at the corners most.
    corner_blocks: f32,
    /// Plane by plane, the sum of its blocks' means.
    sums: Vec<f32>,
}

impl SmoothSurface {
    fn level(&self, plane: usize) -> f32 {
        self.sums[plane] / self.blocks
    }

    fn is_alike(&self, other: &SmoothSurface, range: f32) -> bool {
        let mut planes = 0..self.sums.len();
        planes.all(|plane| (self.level(plane) - other.level(plane)).abs() <= SAME_PART * range)
    }
}

impl SmoothSurfaces {
    /// What neighbours commonly differ by is told from the whole of a table, and from the border of one object's picture.
    fn of(blocks: &Blocks, means: &[Vec<f32>], range: f32, deviations: f32, scene: Scene) -> SmoothSurfaces {
        let (columns, rows) = (blocks.columns, blocks.rows);
        let steps: Vec<Step> = REACHES
            .iter()
            .flat_map(|&reach| [(reach, 0), (0, reach)])
            .filter(|&(dx, dy)| dx < columns && dy < rows)
            .map(|(dx, dy)| {
                let limits = means.iter().map(|means| {
                    let mut apart: Vec<f32> = (0..(rows - dy) * (columns - dx))
                        .map(|k| k / (columns - dx) * columns + k % (columns - dx))
                        .filter(|&block| {
                            let other = block + dy * columns + dx;
                            scene == Scene::Table || blocks.is_at_border(block) && blocks.is_at_border(other)
                        })
                        .map(|block| (means[block + dy * columns + dx] - means[block]).abs())
                        .collect();
                    let common =
                        quantile_nearest(&mut apart, GROUND_NEIGHBOURS, f32::total_cmp).unwrap_or(0.0);
                    deviations * common / GROUND_NEIGHBOURS_SIGMAS + SMOOTH_PART * range
                });
                Step { dx, dy, limits: limits.collect() }
            })
            .collect();
        const NONE: usize = usize::MAX;
        let (mut of_block, mut surfaces, mut waiting) = (vec![NONE; blocks.count()], vec![], vec![]);
        for first in 0..blocks.count() {
            if of_block[first] != NONE {
                continue;
            }
            let number = surfaces.len();
            let mut surface = SmoothSurface { sums: vec![0.0; means.len()], ..SmoothSurface::default() };
            of_block[first] = number;
            waiting.push(first);
            while let Some(block) = waiting.pop() {
                surface.blocks += 1.0;
                surface.sums.iter_mut().zip(means).for_each(|(sum, means)| *sum += means[block]);
                if blocks.is_at_border(block) {
                    let [x, y] = blocks.position(block);
                    surface.border_blocks += 1.0;
                    surface.corner_blocks += (x * y).abs() as f32;
                }
                let (x, y) = (block % columns, block / columns);
                for Step { dx, dy, limits } in &steps {
                    let by = dy * columns + dx;
                    let after = (x + dx < columns && y + dy < rows).then(|| block + by);
                    let before = (x >= *dx && y >= *dy).then(|| block - by);
                    for other in after.into_iter().chain(before) {
                        let is_near = (means.iter().zip(limits))
                            .all(|(means, limit)| (means[other] - means[block]).abs() <= *limit);
                        if is_near && of_block[other] == NONE {
                            of_block[other] = number;
                            waiting.push(other);
                        }
                    }
                }
            }
            surfaces.push(surface);
        }
        SmoothSurfaces { of_block, surfaces }
    }

    /// The blocks of the ground. Of a table: of the surface with most of the picture and of its border. Of one object's
    /// picture: of the surfaces of one level with most of the border. What is on the wrong side of it can't be parts.
    fn ground(
        &self,
        blocks: &Blocks,
        means: &[Vec<f32>],
        range: f32,
        polarity: Polarity,
        scene: Scene,
    ) -> Vec<bool> {
        let border = 2.0 * (blocks.columns + blocks.rows) as f32;
        let share = |surface: &SmoothSurface| match scene {
            Scene::Table => {
                surface.blocks / blocks.count() as f32 + BORDER_WEIGHT * surface.border_blocks / border
            }
            Scene::OneObject => self.alike(surface, range).map(|other| other.corner_blocks / border).sum(),
        };
        let rightness = |surface: &SmoothSurface| {
            let (level, limit) = (surface.level(0), UNEVEN_PART * range);
            let is_wrong = |mean: f32| match polarity {
                Polarity::Either => false,
                Polarity::LightOnDark => mean < level - limit,
                Polarity::DarkOnLight => mean > level + limit,
            };
            let wrong = means[0].iter().filter(|&&mean| is_wrong(mean)).count();
            (1.0 - wrong as f32 / blocks.count() as f32).powi(4)
        };
        let Some(mut best) = self.surfaces.first() else { return vec![] };
        let mut best_share = 0.0;
        for surface in
            self.surfaces.iter().filter(|surface| surface.border_blocks > 0.0 || scene == Scene::Table)
        {
            let most = share(surface);
            if most > best_share {
                let share = most * rightness(surface);
                if share > best_share {
                    (best, best_share) = (surface, share);
                }
            }
        }
        let is_ground = |surface: &SmoothSurface| match scene {
            Scene::Table => std::ptr::eq(surface, best),
            Scene::OneObject => surface.border_blocks > 0.0 && surface.is_alike(best, range),
        };
        let is_ground: Vec<bool> = self.surfaces.iter().map(is_ground).collect();
        self.of_block.iter().map(|&number| is_ground[number]).collect()
    }

    /// The surfaces at the border whose level is that of one.
    fn alike<'a>(
        &'a self,
        surface: &'a SmoothSurface,
        range: f32,
    ) -> impl Iterator<Item = &'a SmoothSurface> {
        let at_border = self.surfaces.iter().filter(|other| other.border_blocks > 0.0);
        at_border.filter(move |other| other.is_alike(surface, range))
    }
}

/// From a block to another one, and by how much they may differ, plane by plane.
struct Step {
    dx: usize,
    dy: usize,
    limits: Vec<f32>,
}

/// The quadratic surface through the ground's blocks by least squares, in every block: term by term, each made orthogonal
/// to those before it over the ground (Gram and Schmidt).
fn quadratic(blocks: &Blocks, means: &[f32], is_ground: &[bool]) -> Vec<f32> {
    let positions: Vec<[f64; 2]> = (0..blocks.count()).map(|block| blocks.position(block)).collect();
    let terms: [fn([f64; 2]) -> f64; 6] =
        [|_| 1.0, |[x, _]| x, |[_, y]| y, |[x, _]| x * x, |[x, y]| x * y, |[_, y]| y * y];
    let means: Vec<f64> = means.iter().map(|&mean| f64::from(mean)).collect();
    let inner = |a: &[f64], b: &[f64]| -> f64 {
        let products = a.iter().zip(b).zip(is_ground);
        products.filter(|(_, is_ground)| **is_ground).map(|((a, b), _)| a * b).sum()
    };
    let add = |to: &mut [f64], factor: f64, v: &[f64]| {
        to.iter_mut().zip(v).for_each(|(to, v)| *to += factor * v);
    };
    let (mut basis, mut levels): (Vec<Vec<f64>>, _) = (Vec::new(), vec![0.0; blocks.count()]);
    for term in terms {
        let mut v: Vec<f64> = positions.iter().map(|&position| term(position)).collect();
        let whole = inner(&v, &v);
        for before in &basis {
            let along = inner(&v, before);
            add(&mut v, -along, before);
        }
        let rest = inner(&v, &v);
        if rest > LEAST_REST * whole {
            v.iter_mut().for_each(|v| *v /= rest.sqrt());
            add(&mut levels, inner(&means, &v), &v);
            basis.push(v);
        }
    }
    levels.into_iter().map(|level| level as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (200, 150);

    /// Light that falls by 70 % from corner to corner, with noise of ±2.
    fn table(x: usize, y: usize) -> f32 {
        let noise = ((x * 37 + y * 101) % 5) as f32 - 2.0;
        120.0 * light(x, y) + noise
    }

    fn light(x: usize, y: usize) -> f32 {
        1.0 - 0.35 * (x as f32 / 200.0 + y as f32 / 150.0)
    }

    /// The ground of the table where `part` gives no level of a part.
    fn ground(polarity: Polarity, part: impl Fn(usize, usize) -> Option<f32>) -> (Ground, Vec<f32>) {
        ground_of(Scene::Table, polarity, part)
    }

    fn ground_of(
        scene: Scene,
        polarity: Polarity,
        part: impl Fn(usize, usize) -> Option<f32>,
    ) -> (Ground, Vec<f32>) {
        let (width, height) = SIZE;
        let levels: Vec<f32> = (0..width * height)
            .map(|at| (at % width, at / width))
            .map(|(x, y)| part(x, y).unwrap_or_else(|| table(x, y)))
            .collect();
        let ground = Ground::of(&[&levels], width, height / 3, polarity, scene);
        let above = ground.differences(&levels, &ground.surfaces[0].levels);
        (ground, levels.iter().zip(above).map(|(v, above)| v - above).collect())
    }

    #[track_caller]
    fn assert_true(ground: &[f32]) {
        for (at, found) in ground.iter().enumerate() {
            let (x, y) = (at % SIZE.0, at / SIZE.0);
            let expected = 120.0 * light(x, y);
            assert!((found - expected).abs() < 2.5, "({x}, {y}): {found}, not {expected}");
        }
    }

    #[test]
    fn neither_light_nor_dark_parts_pull_the_ground() {
        let disc = |x: usize, y: usize, at: [f32; 2]| (x as f32 - at[0]).hypot(y as f32 - at[1]) < 22.0;
        let (ground, levels) = ground(Polarity::Either, |x, y| match () {
            () if disc(x, y, [50.0, 50.0]) => Some(220.0),
            () if disc(x, y, [140.0, 100.0]) => Some(2.0),
            () if (70..74).contains(&y) => Some(5.0),
            () => None,
        });
        assert_true(&levels);
        let deviation = ground.surfaces[0].deviation;
        assert!((1.0..2.6).contains(&deviation), "{deviation}");
    }

    #[test]
    fn the_ground_beneath_a_part_larger_than_a_window_is_that_around_it() {
        let (_, levels) = ground(Polarity::Either, |x, y| {
            ((25..175).contains(&x) && (20..130).contains(&y)).then_some(200.0)
        });
        assert_true(&levels);
    }

    #[test]
    fn what_parts_can_not_be_darker_than_is_no_ground() {
        // A light table in a dark surround: dark parts lie on the table.
        let surround = |x: usize, y: usize| !(20..180).contains(&x) || !(15..135).contains(&y);
        let level = |polarity| ground(polarity, |x, y| surround(x, y).then_some(4.0)).1[75 * SIZE.0 + 100];
        assert!(level(Polarity::DarkOnLight) > 60.0);
        assert!(level(Polarity::Either) < 20.0);
    }
    #[test]
    fn an_object_that_reaches_the_border_all_round_leaves_the_ground_its_corners() {
        // Shaded as a ball is, so that neighbours differ as little as those of the ground do.
        let ball = |x: usize, y: usize| {
            let (dx, dy) = ((x as f32 - 99.5) / 104.0, (y as f32 - 74.5) / 79.0);
            let radius = dx.hypot(dy);
            (radius < 1.0).then_some(210.0 - 60.0 * radius * radius)
        };
        for polarity in [Polarity::LightOnDark, Polarity::Either] {
            let (_, levels) = ground_of(Scene::OneObject, polarity, |x, y| ball(x, y).or(Some(12.0)));
            let farthest = levels.iter().map(|level| (level - 12.0).abs()).fold(0.0, f32::max);
            assert!(farthest < 3.0, "{polarity:?}: {farthest}");
        }
    }
}
