//! A focal pair of 512 × 480 pixels: each method, and its stages. Decoding both PNG files is the baseline.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use landmarkd_core::depth::scene::{Camera, Relief, Scene, Texture, bench_optics};
use landmarkd_core::depth::{Calibration, DepthOptions, Estimator, Method, Stage, Window};
use landmarkd_core::imaging::{DecodeLimits, decode};

fn depth(criterion: &mut Criterion) {
    let optics = bench_optics(8.0, true);
    let camera = Camera { width: 512, height: 480, ..Camera::new(optics) };
    let seen = camera.photograph(&Scene::new(Relief::Slant, Texture::Gravel, 1));
    let (pair, files) = (seen.pair().expect("the bench's own input is valid"), seen.pngs());
    let calibration = Calibration::of(optics);
    let made = |method, window| {
        Estimator::new(&calibration, &DepthOptions { method, window, ..DepthOptions::default() })
            .expect("the bench's own input is valid")
    };
    let gram = made(Method::Gram, Window::Auto);
    let cases = [
        ("gram", gram.clone()),
        ("gram, one window", made(Method::Gram, Window::Px(4.0))),
        ("stm", made(Method::Stm, Window::Auto)),
    ];

    let mut group = criterion.benchmark_group("depth");
    group.sample_size(20);
    group.bench_function("baseline: decode both", |bencher| {
        bencher.iter(|| {
            files.each_ref().map(|file| {
                decode(black_box(file), &DecodeLimits::default()).expect("the bench's own input is valid")
            })
        });
    });
    group.bench_function("design the kernels", |bencher| bencher.iter(|| made(Method::Gram, Window::Auto)));
    for (name, estimator) in &cases {
        group.bench_function(*name, |bencher| {
            bencher.iter(|| {
                estimator.estimate(black_box(&pair), &mut |_| {}).expect("the bench's own input is valid")
            });
        });
    }
    for (name, stage) in [
        ("gram: register", Stage::Register),
        ("gram: match", Stage::Match),
        ("gram: estimate", Stage::Estimate),
        ("gram: judge", Stage::Map),
    ] {
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|rounds| {
                let mut all = Duration::ZERO;
                for _ in 0..rounds {
                    let mut since = Instant::now();
                    gram.estimate(black_box(&pair), &mut |done| {
                        let took = since.elapsed();
                        since = Instant::now();
                        all += if done == stage { took } else { Duration::ZERO };
                    })
                    .expect("the bench's own input is valid");
                }
                all
            });
        });
    }
    group.finish();
}

criterion_group!(benches, depth);
criterion_main!(benches);
