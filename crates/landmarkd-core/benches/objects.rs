//! A 128 × 128 picture against 20 objects of 36 views: decoding it, recognising it, and the stages of that; and the
//! training of the 720 views. Decoding the PNG is the baseline: recognition should cost no more than a few of it.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::imaging::encode::png_gray8;
use landmarkd_core::imaging::{DecodeLimits, Frame, Image, decode};
use landmarkd_core::recognition::objects::{
    Normaliser, ObjectOptions, Stage, View, ViewName, is_trial, train,
};

const SIDE_PX: usize = 128;

/// Ten spots on a turning thing, another for each seed.
fn thing(seed: u64, turn_deg: f64) -> Image {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    let spots: Vec<[f64; 4]> = (0..10)
        .map(|_| {
            let (radius, around, height) =
                (45.0 * next(), (360.0 * next() + turn_deg).to_radians(), 90.0 * next() - 45.0);
            [radius * around.sin(), height, 0.6 + 0.4 * around.cos(), 15.0 + 80.0 * next()]
        })
        .collect();
    Image::from_fn(SIDE_PX, SIDE_PX, |x, y| {
        let (x, y) = (x as f64 - 64.0, y as f64 - 64.0);
        let light = spots.iter().map(|[sx, sy, bright, size]| {
            220.0 * bright * (-((x - sx).powi(2) + (y - sy).powi(2)) / size).exp()
        });
        light.sum::<f64>().min(255.0) as f32
    })
}

fn objects(criterion: &mut Criterion) {
    let options = ObjectOptions::default();
    let normaliser = Normaliser::new(&options, (SIDE_PX as u32, SIDE_PX as u32));
    let views: Vec<View> = (0..20)
        .flat_map(|seed| (0..36).map(move |view| (seed, 10.0 * f64::from(view))))
        .enumerate()
        .map(|(place, (seed, pose_deg))| {
            let id = format!("{seed} {pose_deg}");
            let name = ViewName { id, label: seed.to_string(), pose_deg: Some(pose_deg) };
            let frame = Frame::gray(thing(seed, pose_deg));
            View::new(&normaliser, name, &frame, is_trial(place, 720)).expect("of the database's size")
        })
        .collect();
    let (model, report) = train(views.clone(), &normaliser, &options).expect("views differ");
    assert_eq!((report.exemplars, report.labels), (720, 20));

    let asked = thing(7, 123.0);
    let bytes: Vec<u8> = asked.pixels().iter().map(|&v| v as u8).collect();
    let png = png_gray8(SIDE_PX, SIDE_PX, &bytes);
    let frame = Frame::gray(asked);
    let mut group = criterion.benchmark_group("128×128 against 20 objects");
    group
        .bench_function("decoding its PNG", |b| b.iter(|| decode(black_box(&png), &DecodeLimits::default())));
    group.bench_function("recognising it", |b| b.iter(|| model.recognise(black_box(&frame), |_| ())));
    for stage in [Stage::Appearance, Stage::Universal, Stage::Object] {
        group.bench_function(format!("{stage:?}"), |b| {
            b.iter_custom(|rounds| {
                let mut spent = Duration::ZERO;
                for _ in 0..rounds {
                    let mut last = Instant::now();
                    let recognised = model.recognise(black_box(&frame), |finished| {
                        let now = Instant::now();
                        if finished == stage {
                            spent += now - last;
                        }
                        last = now;
                    });
                    black_box(recognised).expect("of the database's size");
                }
                spent
            });
        });
    }
    group.sample_size(10).bench_function("training 720 views", |b| {
        b.iter(|| train(black_box(views.clone()), &normaliser, &options));
    });
    group.finish();
}

criterion_group!(benches, objects);
criterion_main!(benches);
