//! The symmetry map of a 256 × 256 and a 640 × 480 picture, radius 6, on one core.

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd::imaging::Image;
use landmarkd::vision::{gradient, interest_points, smoothed, symmetry_map};

/// Overlapping discs of different greys: edges everywhere, at all angles.
fn picture(width: usize, height: usize) -> Image {
    Image::from_fn(width, height, |x, y| {
        let level = |size: usize| {
            let (dx, dy) = ((x % size) as f32 - size as f32 / 2.0, (y % size) as f32 - size as f32 / 2.0);
            if dx * dx + dy * dy < (size * size) as f32 / 9.0 {
                (37 * (x / size + 3 * (y / size)) % 200) as f32
            } else {
                0.0
            }
        };
        0.4 * level(23) + 0.4 * level(41) + 0.2 * level(67)
    })
}

fn steps(criterion: &mut Criterion) {
    for (width, height) in [(256, 256), (640, 480)] {
        let mut group = criterion.benchmark_group(format!("attention {width}×{height}"));
        let raw = picture(width, height);
        let smooth = smoothed(&raw, 1.0);
        let map = symmetry_map(&smooth, 6);
        group.bench_function("smoothing", |b| b.iter(|| smoothed(&raw, 1.0)));
        group.bench_function("gradient", |b| b.iter(|| gradient(&smooth)));
        group.bench_function("symmetry map", |b| b.iter(|| symmetry_map(&smooth, 6)));
        group.bench_function("interest points", |b| b.iter(|| interest_points(&map)));
        group.finish();
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
