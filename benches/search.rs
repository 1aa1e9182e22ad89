//! The nearest of N eigenpoints of D coordinates for 64 queries: the tree beside looking at all.
//!
//! Coordinates spread as the eigenvalues of real signatures do, ever less: half the variance lies in the
//! first few. Half of the queries are eigenpoints seen again with some noise (a hit), half are new (a
//! miss): background is always new, and a tree has to look at most of its leaves for it.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use landmarkd::eigen::EigenpointIndex;

const QUERIES: usize = 64;

fn cloud(count: usize, dimension: usize, mut state: u64) -> Vec<f32> {
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    // a sum of four is bell-shaped enough
    let mut bell = || uniform() + uniform() + uniform() + uniform();
    (0..count * dimension).map(|i| 0.2 * bell() / ((i % dimension) as f32 + 1.0).sqrt()).collect()
}

fn search(criterion: &mut Criterion) {
    for dimension in [8, 16, 32, 64] {
        let mut group = criterion.benchmark_group(format!("64 queries of {dimension} coordinates"));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_secs(1));
        group.throughput(Throughput::Elements(QUERIES as u64));
        for count in [1_280, 10_000, 100_000] {
            let points = cloud(count, dimension, 1);
            let new = cloud(QUERIES, dimension, 2);
            let noise = cloud(QUERIES / 2, dimension, 3);
            let again = (points.iter().zip(&noise)).map(|(p, n)| p + 0.05 * n);
            let queries: Vec<f32> = again.chain(new[noise.len()..].iter().copied()).collect();
            let index = EigenpointIndex::with_tree(points, dimension);
            assert!(index.has_tree());
            group.bench_with_input(BenchmarkId::new("tree", count), &queries, |b, queries| {
                b.iter(|| black_box(index.nearest(queries)));
            });
            group.bench_with_input(BenchmarkId::new("looking at all", count), &queries, |b, queries| {
                b.iter(|| black_box(index.nearest_exhaustive(queries)));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, search);
criterion_main!(benches);
