//! How much of this machine the two loops of a description use: symmetry over the scale space of a 640 × 480 picture, and
//! 1000 signatures of gradient directions. Operations and bytes are counted, and held against the least time that this
//! machine needs for so many (the roofline; Williams, Waterman and Patterson 2009): products and sums in registers, and a
//! copy of what no cache holds, both measured here. Printed before the timings, whose baseline is the copy.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::Image;
use landmarkd_core::vision::gradient_signature::{GradientSignature, SIGNATURE_LENGTH, SPECTRUM_LENGTH};
use landmarkd_core::vision::scale_space::{Level, scale_space};
use landmarkd_core::vision::{PaddedGradient, smoothed, symmetry_map};
use pulp::{Arch, Simd, WithSimd};

const RADIUS_PX: usize = 6;
const WINDOWS: usize = 1000;
const ROUNDS: usize = 15;

/// Products and sums that wait for no other and for no memory.
struct Peak;

impl Peak {
    const STEPS: usize = 1 << 20;
    const SUMS: usize = 12;
}

impl WithSimd for Peak {
    /// Operations.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut sums = [simd.splat_f32s(1.0); Peak::SUMS];
        let (factor, more) = (simd.splat_f32s(black_box(0.999)), simd.splat_f32s(black_box(0.001)));
        for _ in 0..Peak::STEPS {
            for sum in &mut sums {
                *sum = simd.add_f32s(simd.mul_f32s(*sum, factor), more);
            }
        }
        black_box(sums);
        (2 * Peak::STEPS * Peak::SUMS * S::F32_LANES) as f64
    }
}

/// What a loop does, and in how many seconds.
struct Work {
    name: &'static str,
    operations: f64,
    bytes: f64,
    seconds: f64,
}

/// The least time of some rounds.
fn least_seconds<T>(mut work: impl FnMut() -> T) -> f64 {
    let timed = (0..ROUNDS).map(|_| {
        let begun = Instant::now();
        black_box(work());
        begun.elapsed().as_secs_f64()
    });
    timed.fold(f64::INFINITY, f64::min)
}

fn picture() -> Image {
    smoothed(&Image::from_fn(640, 480, |x, y| ((x * x * 7 + y * 31 + x * y) % 251) as f32), 1.0)
}

/// Nine operations for each of 56 pairs about every pixel, and some 8 for the edge there. A pixel is read once, three
/// numbers are written for it and read again, and one is the answer.
fn symmetry_work(levels: &[Level]) -> Work {
    let pixels: usize = levels.iter().map(|level| level.image.pixels().len()).sum();
    Work {
        name: "symmetry over the scale space",
        operations: pixels as f64 * (9.0 * 56.0 + 8.0),
        bytes: pixels as f64 * 4.0 * (1.0 + 3.0 + 3.0 + 1.0),
        seconds: least_seconds(|| symmetry(levels)),
    }
}

fn symmetry(levels: &[Level]) -> Vec<Image> {
    levels.iter().map(|level| symmetry_map(&level.image, RADIUS_PX)).collect()
}

/// 60 000 operations a window (benches/signature.rs has them one by one); 384 samples of four pairs of pixels are read.
fn signature_work(plan: &GradientSignature, gradient: &PaddedGradient, points: &[[usize; 2]]) -> Work {
    let numbers = 384 * 8 + SIGNATURE_LENGTH + SPECTRUM_LENGTH;
    Work {
        name: "signatures of gradient directions",
        operations: points.len() as f64 * 60_000.0,
        bytes: (points.len() * numbers * size_of::<f32>()) as f64,
        seconds: least_seconds(|| plan.describe(gradient, points)),
    }
}

fn roofline(criterion: &mut Criterion) {
    let levels = scale_space(&picture(), 2, 6);
    let plan = GradientSignature::new(14.0);
    let gradient = PaddedGradient::new(&levels[0].image, plan.reach_px());
    let points: Vec<[usize; 2]> = (0..WINDOWS).map(|i| [5 + 15 * (i % 40), 4 + 19 * (i / 40)]).collect();
    let far = vec![1.0_f32; 1 << 24];
    let mut copy = far.clone();

    let operations = Arch::new().dispatch(Peak);
    let per_second = operations / least_seconds(|| Arch::new().dispatch(Peak));
    let bytes_per_second = 2.0 * size_of_val(&far[..]) as f64
        / least_seconds(|| black_box(&mut copy).copy_from_slice(black_box(&far)));
    println!(
        "this core: {:.1} GFLOP/s of products and sums, {:.1} GB/s",
        per_second / 1e9,
        bytes_per_second / 1e9
    );
    for work in [symmetry_work(&levels), signature_work(&plan, &gradient, &points)] {
        let floor = (work.operations / per_second).max(work.bytes / bytes_per_second);
        println!(
            "{}: {:.1} MFLOP, {:.1} MB, {:.2} ms: {:.0} % of the roofline",
            work.name,
            work.operations / 1e6,
            work.bytes / 1e6,
            1e3 * work.seconds,
            100.0 * floor / work.seconds
        );
    }

    let mut group = criterion.benchmark_group("roofline, 640×480");
    group.sample_size(20);
    group.bench_function("copy of the scale space", |b| b.iter(|| black_box(&levels).clone()));
    group.bench_function("symmetry over the scale space", |b| b.iter(|| symmetry(&levels)));
    group.bench_function("1000 signatures", |b| b.iter(|| plan.describe(&gradient, &points)));
    group.finish();
}

criterion_group!(benches, roofline);
criterion_main!(benches);
