//! How much of this machine the two loops of a description use: symmetry over the scale space of a 640 × 480 picture, and
//! 1000 signatures of gradient directions. Operations and bytes are counted, and held against the least time that this
//! machine needs for so many (the roofline; Williams, Waterman and Patterson 2009): products and sums in registers, and a
//! copy of what no cache holds, both measured here. Printed before the timings, whose baseline is the copy.

mod machine;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::Image;
use landmarkd_core::vision::gradient_signature::{GradientSignature, SIGNATURE_LENGTH, SPECTRUM_LENGTH};
use landmarkd_core::vision::scale_space::{Level, scale_space};
use landmarkd_core::vision::{PaddedGradient, smoothed, symmetry_map};
use machine::{Machine, least_seconds};

const RADIUS_PX: usize = 6;
const WINDOWS: usize = 1000;

/// What a loop does, and in how many seconds.
struct Work {
    name: &'static str,
    operations: f64,
    bytes: f64,
    seconds: f64,
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
    let machine = Machine::measured();
    for work in [symmetry_work(&levels), signature_work(&plan, &gradient, &points)] {
        let floor = machine.floor(work.operations, work.bytes);
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
