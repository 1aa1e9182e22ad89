//! The blur of a rig whose aperture is not known, measured from one textured pair.
//!
//! At the right depth H_f·N = H_n·F at every frequency (N, F the spectra of a part of both pictures), whatever the texture.
//! Small blurs leave only the difference of their squares, which another depth makes as well; but where πdρ reaches 1 the
//! transfer function's own shape shows, and only the right scale explains all frequencies of all parts together. So for
//! each scale every part takes the β that explains it best, and the scale with the least misfit over all parts wins:
//! L = Σ n·ln E, the likelihood of parts whose noise isn't known. Its error is that of leaving out an eighth of the picture
//! in turn (jackknife).

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use thiserror::Error;

use super::otf::pillbox;
use super::{Calibration, DepthOptions, Estimator, FocalPair, Method, Optics, Warning};
use crate::imaging::Image;

/// Blur found in a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurScale {
    /// The optics with the apertures that make this blur.
    pub optics: Optics,
    /// Standard deviation of its largest blur, in pixels.
    pub sigma_px: f64,
}

/// Why no blur scale is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum BlurScaleError {
    /// Several scales explain the pair about equally well.
    #[error("the pictures fix no blur between {} and {} px: several explain them about equally well", BLURS_PX[0], BLURS_PX[1])]
    Unclear,
}

/// Side of a part in pixels.
const TILE_PX: usize = 64;
/// Longest side of what is looked at, in pixels.
const MOST_SIDE_PX: usize = 1024;
/// Lowest and highest frequency used, in periods a part: the window prevails below, pixels alias above.
const PERIODS: std::ops::Range<usize> = 2..23;
/// The least and the largest blur that are looked for, in pixels: smaller ones show too little of their shape.
const BLURS_PX: [f64; 2] = [3.5, 12.0];
/// Scales, evenly spaced in their logarithm.
const SCALES: usize = 53;
/// Candidates of β, and the outermost.
const BETAS: usize = 85;
const OUTERMOST: f64 = 1.05;
/// Parts are left out by so many groups.
const GROUPS: usize = 8;
/// Scales that lie so many steps beside the best, a tenth of it, must fit worse: by this much in n·ln E a part.
const BESIDE: usize = 4;
const LEAST_RISE: f64 = 1.2;
/// The most that the groups may scatter by, as a part of the blur.
const MOST_SCATTER: f64 = 0.1;
/// What depths within a part, and its window, make of the blur, as a part of it: standard deviation on rendered scenes.
const MODEL_SIGMA: f64 = 0.025;
/// The blur that pictures are registered and matched by.
const ASSUMED_BLUR_PX: f64 = 6.0;

/// Powers and the common spectrum of a part of both pictures, by periods.
struct Tile {
    near: [f64; PERIODS.end],
    far: [f64; PERIODS.end],
    both: [f64; PERIODS.end],
    frequencies: f64,
}

/// The blur scale of a rig of two focus settings from one of its pairs; the aperture of `optics` doesn't count.
///
/// # Errors
/// [`BlurScaleError`]: too little fine texture, or all of it at one distance in the middle of the range; two apertures,
/// whose blur another distance makes as well.
pub fn blur_scale(optics: &Optics, pair: &FocalPair) -> Result<BlurScale, BlurScaleError> {
    let assumed = optics.with_largest_blur(ASSUMED_BLUR_PX);
    let options = DepthOptions { method: Method::Stm, ..DepthOptions::default() };
    let registered = Estimator::without_table(&Calibration::of(assumed), &options).matched(pair);
    let tiles = tiles(&registered.near, &registered.far);
    let scales: Vec<f64> = (0..SCALES)
        .map(|k| BLURS_PX[0] * (BLURS_PX[1] / BLURS_PX[0]).powf(k as f64 / (SCALES - 1) as f64))
        .collect();
    let misfits: Vec<Vec<f64>> =
        scales.iter().map(|&blur_px| misfits(&optics.with_largest_blur(blur_px), &tiles)).collect();
    let curve_without = |left_out: Option<usize>| -> Vec<f64> {
        let group = |tile: usize| tile * GROUPS / tiles.len();
        let sum = |misfits: &Vec<f64>| -> f64 {
            let kept = misfits.iter().enumerate().filter(|(tile, _)| Some(group(*tile)) != left_out);
            kept.map(|(_, misfit)| misfit).sum()
        };
        misfits.iter().map(sum).collect()
    };
    let curve = curve_without(None);
    let place = minimum(&curve);
    let without: Vec<f64> = (0..GROUPS).map(|group| minimum(&curve_without(Some(group)))).collect();
    let mean = without.iter().sum::<f64>() / GROUPS as f64;
    let squares: f64 = without.iter().map(|place| (place - mean).powi(2)).sum();
    let step = (BLURS_PX[1] / BLURS_PX[0]).ln() / (SCALES - 1) as f64;
    // (G − 1)/G Σ(x − x̄)²
    let scatter = step * (squares * (GROUPS - 1) as f64 / GROUPS as f64).sqrt();
    let at = place.round() as usize;
    let rise = |to: usize| (curve[to] - curve[at]) / tiles.len() as f64;
    let is_inside = (BESIDE..SCALES - BESIDE).contains(&at);
    let is_clear =
        is_inside && rise(at - BESIDE).min(rise(at + BESIDE)) >= LEAST_RISE && scatter <= MOST_SCATTER;
    // Scale and distance of an aperture pair are one thing, and a pattern that fixes no shift has too few frequencies.
    let is_blind = optics.range_end_mm.is_some() || registered.warnings.contains(&Warning::ShiftUnknown);
    if is_blind || !is_clear {
        return Err(BlurScaleError::Unclear);
    }
    let largest_px = BLURS_PX[0] * (step * place).exp();
    Ok(BlurScale {
        optics: optics.with_largest_blur(largest_px),
        sigma_px: largest_px * scatter.hypot(MODEL_SIGMA),
    })
}

/// Where a curve is least, by the parabola about its lowest point.
fn minimum(curve: &[f64]) -> f64 {
    let lowest = (0..curve.len()).min_by(|&a, &b| curve[a].total_cmp(&curve[b])).unwrap_or(0);
    if lowest == 0 || lowest + 1 == curve.len() {
        return lowest as f64;
    }
    let [before, here, after] = [curve[lowest - 1], curve[lowest], curve[lowest + 1]];
    lowest as f64 + 0.5 * (before - after) / (before - 2.0 * here + after).max(f64::MIN_POSITIVE)
}

/// The least value of a curve, by the parabola about its lowest point.
fn least(curve: &[f64]) -> f64 {
    let lowest = (0..curve.len()).min_by(|&a, &b| curve[a].total_cmp(&curve[b])).unwrap_or(0);
    let here = curve[lowest];
    if lowest == 0 || lowest + 1 == curve.len() {
        return here;
    }
    let [before, after] = [curve[lowest - 1], curve[lowest + 1]];
    let second_difference = (before - 2.0 * here + after).max(f64::MIN_POSITIVE);
    here - (before - after).powi(2) / (8.0 * second_difference)
}

/// n·ln E of each part at the β that explains it best.
fn misfits(optics: &Optics, tiles: &[Tile]) -> Vec<f64> {
    let transfers: Vec<[[f64; 2]; PERIODS.end]> = (0..BETAS)
        .map(|k| {
            let beta = OUTERMOST * (2.0 * k as f64 / (BETAS - 1) as f64 - 1.0);
            let blur_px = optics.registered_blur_px(beta);
            std::array::from_fn(|periods| {
                let cycles = periods as f64 / TILE_PX as f64;
                let transfer = blur_px.map(|diameter_px| pillbox(cycles, diameter_px));
                let length = transfer[0].hypot(transfer[1]).max(1e-3);
                transfer.map(|h| h / length)
            })
        })
        .collect();
    let misfit = |tile: &Tile| {
        let energy = |transfers: &[[f64; 2]; PERIODS.end]| -> f64 {
            let terms = PERIODS.map(|k| {
                let [near, far] = transfers[k];
                far * far * tile.near[k] + near * near * tile.far[k] - 2.0 * near * far * tile.both[k]
            });
            terms.sum()
        };
        let energies: Vec<f64> = transfers.iter().map(energy).collect();
        tile.frequencies * least(&energies).max(f64::MIN_POSITIVE).ln()
    };
    tiles.iter().map(misfit).collect()
}

/// The spectra of overlapping parts, under a cosine window.
fn tiles(near: &Image, far: &Image) -> Vec<Tile> {
    let [near, far] = [near, far].map(|image| image.middle(MOST_SIDE_PX));
    let window: Vec<f64> = (0..TILE_PX)
        .map(|k| 0.5 - 0.5 * (std::f64::consts::TAU * (k as f64 + 0.5) / TILE_PX as f64).cos())
        .collect();
    let transform = FftPlanner::new().plan_fft_forward(TILE_PX);
    let starts = |side: usize| (0..(side + 1).saturating_sub(TILE_PX)).step_by(TILE_PX / 2);
    let mut tiles = Vec::new();
    for top in starts(near.height()) {
        for left in starts(near.width()) {
            let mean = |image: &Image| {
                let rows = (top..top + TILE_PX).map(|y| &image.row(y)[left..left + TILE_PX]);
                rows.flatten().map(|&v| f64::from(v)).sum::<f64>() / (TILE_PX * TILE_PX) as f64
            };
            let means = [mean(&near), mean(&far)];
            let mut values: Vec<Complex64> = (0..TILE_PX * TILE_PX)
                .map(|at| {
                    let (x, y) = (at % TILE_PX, at / TILE_PX);
                    let level = |image: &Image| f64::from(image.row(top + y)[left + x]);
                    Complex64::new(level(&near) - means[0], level(&far) - means[1]) * window[x] * window[y]
                })
                .collect();
            for _ in 0..2 {
                transform.process(&mut values);
                values =
                    (0..TILE_PX * TILE_PX).map(|at| values[at % TILE_PX * TILE_PX + at / TILE_PX]).collect();
            }
            tiles.push(Tile::of(&values));
        }
    }
    tiles
}

impl Tile {
    /// Of the transform of near + i·far.
    fn of(values: &[Complex64]) -> Tile {
        let mut tile = Tile {
            near: [0.0; PERIODS.end],
            far: [0.0; PERIODS.end],
            both: [0.0; PERIODS.end],
            frequencies: 0.0,
        };
        let signed = |k: usize| (k as f64) - if k > TILE_PX / 2 { TILE_PX as f64 } else { 0.0 };
        // Half of the plane: the other half repeats it.
        for i in 0..=TILE_PX / 2 {
            for j in 0..TILE_PX {
                let periods = signed(i).hypot(signed(j)).round() as usize;
                if !PERIODS.contains(&periods) {
                    continue;
                }
                let z = values[i * TILE_PX + j];
                let mirrored = values[(TILE_PX - i) % TILE_PX * TILE_PX + (TILE_PX - j) % TILE_PX].conj();
                let (n, f) = ((z + mirrored) * 0.5, (z - mirrored) * Complex64::new(0.0, -0.5));
                tile.near[periods] += n.norm_sqr();
                tile.far[periods] += f.norm_sqr();
                tile.both[periods] += (n * f.conj()).re;
                tile.frequencies += 1.0;
            }
        }
        tile
    }
}
