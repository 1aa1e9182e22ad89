//! Seeded random numbers (SplitMix64): the same frames in every run, on every machine.

/// A stream of random numbers.
pub struct Random(u64);

impl Random {
    /// The stream of a seed and a key, such as a trial's number: streams of other keys don't depend on it.
    pub fn of(seed: u64, key: &[u64]) -> Random {
        let mut stream = Random(seed);
        for part in key {
            stream.0 = stream.next() ^ part;
        }
        stream
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly in [least, most).
    pub fn uniform(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Evenly in 0..count.
    pub fn below(&mut self, count: usize) -> usize {
        (self.uniform(0.0, count as f64) as usize).min(count - 1)
    }

    /// Normal, mean 0, deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform(0.0, 1.0)).ln()).sqrt();
        radius * self.uniform(0.0, std::f64::consts::TAU).cos()
    }
}

#[test]
fn uniform_and_normal_numbers_have_their_mean_and_spread() {
    let mut random = Random::of(1, &[2, 3]);
    let numbers: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
    let mean = numbers.iter().sum::<f64>() / 20_000.0;
    let variance = numbers.iter().map(|v| v * v).sum::<f64>() / 20_000.0;
    assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.05, "{mean} {variance}");
    let counts = (0..20_000).fold([0; 4], |mut counts, _| {
        counts[random.below(4)] += 1;
        counts
    });
    assert!(counts.iter().all(|count| (4_800..5_200).contains(count)), "{counts:?}");
}
