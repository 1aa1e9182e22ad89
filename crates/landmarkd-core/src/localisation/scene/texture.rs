//! A picture to be looked at from near and far: its texels at every power of two.

use crate::imaging::Frame;

/// A picture in colour at full, half, quarter… size.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    width: usize,
    height: usize,
    /// Red, green, blue, row-major.
    texels: Vec<[u8; 3]>,
}

impl Texture {
    /// Of texels, row-major.
    pub fn new(width: usize, height: usize, texels: Vec<[u8; 3]>) -> Texture {
        let mut levels = vec![Level { width, height, texels }];
        while let Some(half) = levels.last().and_then(Level::half) {
            levels.push(half);
        }
        Texture { levels }
    }

    /// Of a picture.
    pub fn of(picture: &Frame) -> Texture {
        let bytes = picture.to_rgb8();
        let texels = bytes.chunks_exact(3).map(|texel| [texel[0], texel[1], texel[2]]).collect();
        Texture::new(picture.width(), picture.height(), texels)
    }

    /// Width and height in texels.
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The texel in column `x` of row `y`.
    pub fn texel(&self, x: usize, y: usize) -> [u8; 3] {
        self.levels[0].texels[y * self.levels[0].width + x]
    }

    /// The colour at a place (0..=1 of the width, of the height), as a mean over a square of so many texels a side:
    /// bilinear within the levels, linear between them.
    pub fn colour(&self, place: [f64; 2], texels: f64) -> [f64; 3] {
        let level = texels.max(1.0).log2().min(self.levels.len() as f64 - 1.0);
        let (fine, part) = (level as usize, level.fract());
        let fine_colour = self.levels[fine].colour(place);
        if part == 0.0 {
            return fine_colour;
        }
        let coarse = self.levels[fine + 1].colour(place);
        std::array::from_fn(|c| fine_colour[c] + part * (coarse[c] - fine_colour[c]))
    }
}

impl Level {
    fn half(&self) -> Option<Level> {
        let (width, height) = (self.width / 2, self.height / 2);
        let mean = |at: usize| {
            let first = at / width * 2 * self.width + at % width * 2;
            let four = [first, first + 1, first + self.width, first + self.width + 1];
            [0, 1, 2]
                .map(|c| (four.iter().map(|i| u16::from(self.texels[*i][c])).sum::<u16>() + 2) / 4)
                .map(|mean| mean as u8)
        };
        (width >= 2 && height >= 2).then(|| Level {
            width,
            height,
            texels: (0..width * height).map(mean).collect(),
        })
    }

    fn colour(&self, place: [f64; 2]) -> [f64; 3] {
        let at = |part: f64, length: usize| (part * length as f64 - 0.5).clamp(0.0, length as f64 - 1.0);
        let (x, y) = (at(place[0], self.width), at(place[1], self.height));
        let (left, top) = ((x as usize).min(self.width - 2), (y as usize).min(self.height - 2));
        let (across, down) = (x - left as f64, y - top as f64);
        let first = top * self.width + left;
        let (upper, lower) = (&self.texels[first..first + 2], &self.texels[first + self.width..][..2]);
        std::array::from_fn(|c| {
            let between = |row: &[[u8; 3]]| {
                let [a, b] = [row[0][c], row[1][c]].map(f64::from);
                a + across * (b - a)
            };
            let (upper, lower) = (between(upper), between(lower));
            upper + down * (lower - upper)
        })
    }
}
