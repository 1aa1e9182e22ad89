//! Signatures of 64 sub-windows of 8 × 32 samples, beside a DFT term by term of the same windows.

use std::f32::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::Image;
use landmarkd_core::vision::{Normalise, PolarGrid, SignaturePlan, Taper};

const RINGS: usize = 8;
const SECTORS: usize = 32;

fn naive(samples: &[f32], amplitudes: &mut [f32]) {
    for (at, amplitude) in amplitudes.iter_mut().enumerate() {
        let (k, m) = (at / RINGS, at % RINGS);
        let (mut re, mut im) = (0.0, 0.0);
        for (i, sample) in samples.iter().enumerate() {
            let (ring, sector) = (i / SECTORS, i % SECTORS);
            let turn = (k * sector) as f32 / SECTORS as f32 + (m * ring) as f32 / RINGS as f32;
            let (sin, cos) = (TAU * turn).sin_cos();
            re += sample * cos;
            im -= sample * sin;
        }
        *amplitude = (re * re + im * im).sqrt();
    }
}

fn signatures(criterion: &mut Criterion) {
    let picture = Image::from_fn(256, 256, |x, y| ((x * x * 7 + y * 31 + x * y) % 251) as f32);
    let grid = PolarGrid::new(5.0, RINGS, SECTORS);
    let plan = SignaturePlan::new(RINGS, SECTORS, Taper::Radial, Normalise::Contrast);
    let places: Vec<(f32, f32)> =
        (0..64).map(|i| ((3 + 31 * (i % 8)) as f32, (3 + 31 * (i / 8)) as f32)).collect();
    let mut samples = vec![0.0; RINGS * SECTORS];
    let mut signature = vec![0.0; plan.length()];
    let mut scratch = plan.scratch();

    let mut group = criterion.benchmark_group("64 signatures of 8×32");
    group.bench_function("sampling", |b| {
        b.iter(|| {
            for &(x, y) in &places {
                grid.sample(&picture, x, y, &mut samples);
                black_box(&samples);
            }
        });
    });
    group.bench_function("sampling and transform", |b| {
        b.iter(|| {
            for &(x, y) in &places {
                grid.sample(&picture, x, y, &mut samples);
                plan.sign(&samples, &mut scratch, &mut signature);
                black_box(&signature);
            }
        });
    });
    group.sample_size(10);
    group.bench_function("sampling and transform term by term", |b| {
        b.iter(|| {
            for &(x, y) in &places {
                grid.sample(&picture, x, y, &mut samples);
                naive(&samples, &mut signature);
                black_box(&signature);
            }
        });
    });
    group.finish();
}

criterion_group!(benches, signatures);
criterion_main!(benches);
