//! A 640 × 480 frame against 20 exemplars, whole and stage by stage, from smoothing to vote.

use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd::imaging::{Frame, Image};
use landmarkd::recognition::landmarks::{ExemplarName, LandmarkOptions, Landmarks, Stage, describe};

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

fn recognition(criterion: &mut Criterion) {
    let options = LandmarkOptions::default();
    let described = |seed: u64| {
        let name = ExemplarName { id: seed.to_string(), label: seed.to_string() };
        describe(name, &scene(seed, 640, 480), &options)
    };
    let (model, report) =
        Landmarks::train((0..20).map(described).collect(), &options).expect("scenes differ");
    assert_eq!(report.interest_points, 20 * 64);
    let frame = scene(7, 640, 480).turned(20.0);

    let mut group = criterion.benchmark_group("640×480 against 20 exemplars");
    group.bench_function("whole", |b| b.iter(|| model.recognise(&frame, |_| ())));
    for stage in [Stage::Attention, Stage::Signature, Stage::Search, Stage::Vote] {
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

criterion_group!(benches, recognition);
criterion_main!(benches);
