//! What one core of this machine gives, measured: products and sums in registers, and a copy of what no cache holds.

use std::hint::black_box;
use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};

const ROUNDS: usize = 15;

/// The two limits of the roofline (Williams, Waterman and Patterson 2009).
pub struct Machine {
    /// Products and sums of f32 in a second.
    pub operations_per_second: f64,
    /// Bytes read or written in a second.
    pub bytes_per_second: f64,
}

impl Machine {
    /// Measures this core, and prints what it gives.
    pub fn measured() -> Machine {
        let far = vec![1.0_f32; 1 << 24];
        let mut copy = far.clone();
        let operations = Arch::new().dispatch(Peak);
        let machine = Machine {
            operations_per_second: operations / least_seconds(|| Arch::new().dispatch(Peak)),
            bytes_per_second: 2.0 * size_of_val(&far[..]) as f64
                / least_seconds(|| black_box(&mut copy).copy_from_slice(black_box(&far))),
        };
        println!(
            "this core: {:.1} GFLOP/s of products and sums, {:.1} GB/s",
            machine.operations_per_second / 1e9,
            machine.bytes_per_second / 1e9
        );
        machine
    }

    /// The least seconds that so many operations and bytes need.
    pub fn floor(&self, operations: f64, bytes: f64) -> f64 {
        (operations / self.operations_per_second).max(bytes / self.bytes_per_second)
    }
}

/// The least time of some rounds.
pub fn least_seconds<T>(mut work: impl FnMut() -> T) -> f64 {
    let timed = (0..ROUNDS).map(|_| {
        let begun = Instant::now();
        black_box(work());
        begun.elapsed().as_secs_f64()
    });
    timed.fold(f64::INFINITY, f64::min)
}

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
