//! Attention on a 256 × 256 and a 640 × 480 picture, radius 6, on one core; beside it the symmetry map as
//! the formula has it, pair by pair with angles, to see what the products save.

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::Image;
use landmarkd_core::vision::{gradient, harris, interest_points, smoothed, symmetry_map};

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

/// The formula's angles and logarithms once a pixel, its cosines once a pair.
fn direct(image: &Image, radius: isize) -> Image {
    let slopes = gradient(image);
    let edges: Vec<(f32, f32)> = (slopes.x.pixels().iter().zip(slopes.y.pixels()))
        .map(|(x, y)| (x.hypot(*y).ln_1p(), y.atan2(*x)))
        .collect();
    let (width, height) = (image.width() as isize, image.height() as isize);
    let edge = |x: isize, y: isize| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        if inside { edges[(y * width + x) as usize] } else { (0.0, 0.0) }
    };
    Image::from_fn(image.width(), image.height(), |x, y| {
        let mut sum = 0.0;
        for (dy, dx) in (0..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dy, dx))) {
            if (dy == 0 && dx <= 0) || dx * dx + dy * dy > radius * radius {
                continue;
            }
            let (distance, alpha) = ((dx as f32).hypot(dy as f32), (dy as f32).atan2(dx as f32));
            let (ri, ti) = edge(x as isize - dx, y as isize - dy);
            let (rj, tj) = edge(x as isize + dx, y as isize + dy);
            let facing = (1.0 - (ti + tj - 2.0 * alpha).cos()) * (1.0 - (ti - tj).cos());
            sum += (-2.0 * distance / radius as f32).exp() * facing * ri * rj;
        }
        sum
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
        if width == 256 {
            group.sample_size(10);
            group.bench_function("symmetry map, as the formula has it", |b| b.iter(|| direct(&smooth, 6)));
        }
        group.bench_function("Harris", |b| b.iter(|| harris(&smooth, 6)));
        group.bench_function("interest points", |b| b.iter(|| interest_points(&map)));
        group.finish();
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
