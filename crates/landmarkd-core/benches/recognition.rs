//! A 256 × 256 frame against 20, 200 and 2000 exemplars, and one of 640 × 480 against 20, whole and stage by stage; the
//! paper's method beside the default. The baseline of all is the symmetry map of the same frame.

use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::{Frame, Image};
use landmarkd_core::recognition::landmarks::{
    ExemplarName, LandmarkOptions, Landmarks, Method, Stage, Viewpoint, describe,
};
use landmarkd_core::vision::symmetry_map;

/// A scene of overlapping discs and bars, another for each seed.
fn scene(seed: u64, width: usize, height: usize) -> Frame {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut picture = Image::from_fn(width, height, |x, y| 40.0 + (x + y) as f32 / 16.0);
    for _ in 0..150 {
        let (cx, cy) = (width as f32 * next(), height as f32 * next());
        let (a, b, tilt, level) = (2.0 + 24.0 * next(), 2.0 + 24.0 * next(), 3.2 * next(), 255.0 * next());
        let reach = a.max(b) as usize + 1;
        for y in (cy as usize).saturating_sub(reach)..(cy as usize + reach).min(height) {
            for x in (cx as usize).saturating_sub(reach)..(cx as usize + reach).min(width) {
                let (dx, dy) = (x as f32 - cx, y as f32 - cy);
                let (u, v) = (dx * tilt.cos() + dy * tilt.sin(), dy * tilt.cos() - dx * tilt.sin());
                if (u / a).powi(2) + (v / b).powi(2) < 1.0 {
                    picture.pixels_mut()[y * width + x] = level;
                }
            }
        }
    }
    Frame::gray(picture)
}

fn model(options: &LandmarkOptions, exemplars: u64, width: usize, height: usize) -> Landmarks {
    let described = |seed: u64| {
        let name = ExemplarName { id: seed.to_string(), label: seed.to_string() };
        describe(name, &scene(seed, width, height), options)
    };
    Landmarks::train((0..exemplars).map(described).collect(), options).expect("scenes differ").0
}

fn recognition(criterion: &mut Criterion) {
    let options = LandmarkOptions::default();
    for (exemplars, width, height) in [(20, 256, 256), (200, 256, 256), (2000, 256, 256), (20, 640, 480)] {
        // exemplars are half as wide as frames, as things in them are
        let model = model(&options, exemplars, width / 2, height / 2);
        let frame = scene(7, width, height).turned(20.0);
        let mut group = criterion.benchmark_group(format!("{width}×{height} against {exemplars} exemplars"));
        group.sample_size(20);
        group.bench_function("symmetry map alone", |b| b.iter(|| symmetry_map(&frame.luminance, 6)));
        group.bench_function("whole", |b| b.iter(|| model.recognise(&frame, |_| ())));
        for stage in [Stage::Attention, Stage::Signature, Stage::Search, Stage::Vote, Stage::Verification] {
            group.bench_function(format!("{stage:?}"), |b| {
                b.iter_custom(|rounds| {
                    let mut spent = Duration::ZERO;
                    for _ in 0..rounds {
                        let mut last = Instant::now();
                        model.recognise(&frame, |finished| {
                            let now = Instant::now();
                            if finished == stage {
                                spent += now - last;
                            }
                            last = now;
                        });
                    }
                    spent
                });
            });
        }
        group.finish();
    }
    let paper = model(&LandmarkOptions::of(Method::Paper, Viewpoint::Free), 20, 128, 128);
    let frame = scene(7, 256, 256).turned(20.0);
    criterion.bench_function("256×256 against 20 exemplars/the paper's method", |b| {
        b.iter(|| paper.recognise(&frame, |_| ()));
    });
}

criterion_group!(benches, recognition);
criterion_main!(benches);
