//! The pixels of a `sensor_msgs/Image`, as the PNG that is sent in its place: without loss, and the same bytes whenever the
//! bag is read again.

use landmarkd_core::imaging::encode::{png_gray8, png_gray16, png_rgb8};

use super::messages::Image;

/// Why an image can't be sent.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum RawImageError {
    /// An encoding that isn't read.
    #[error(
        "the encoding {0:?} isn't read: record rgb8, bgr8, rgba8, bgra8, mono8, mono16, yuv422 (uyvy), yuv422_yuy2 (yuyv) or \
         bayer_*8, or the topic's /compressed"
    )]
    Encoding(String),
    /// The data are too short for the size.
    #[error("{width}×{height} pixels of {encoding} in rows of {step} bytes don't fit {bytes} bytes")]
    Size { width: u32, height: u32, encoding: String, step: u32, bytes: usize },
}

/// How the samples of a row lie.
#[derive(Clone, Copy)]
enum Layout {
    Gray8,
    Gray16,
    /// Bytes of a pixel, and where r, g, b are among them.
    Colour(usize, [usize; 3]),
    /// Bytes of two pixels: where their levels are, then Cb and Cr.
    Yuv422([usize; 2], usize, usize),
    /// The colours (0 r, 1 g, 2 b) of the first two rows' first two pixels.
    Bayer([[usize; 2]; 2]),
}

impl Layout {
    fn of(encoding: &str) -> Option<Layout> {
        Some(match encoding {
            "mono8" | "8UC1" => Layout::Gray8,
            "mono16" | "16UC1" => Layout::Gray16,
            "rgb8" => Layout::Colour(3, [0, 1, 2]),
            "bgr8" | "8UC3" => Layout::Colour(3, [2, 1, 0]),
            "rgba8" => Layout::Colour(4, [0, 1, 2]),
            "bgra8" | "8UC4" => Layout::Colour(4, [2, 1, 0]),
            "yuv422" | "uyvy" => Layout::Yuv422([1, 3], 0, 2),
            "yuv422_yuy2" | "yuyv" => Layout::Yuv422([0, 2], 1, 3),
            "bayer_rggb8" => Layout::Bayer([[0, 1], [1, 2]]),
            "bayer_bggr8" => Layout::Bayer([[2, 1], [1, 0]]),
            "bayer_gbrg8" => Layout::Bayer([[1, 2], [0, 1]]),
            "bayer_grbg8" => Layout::Bayer([[1, 0], [2, 1]]),
            _ => return None,
        })
    }

    /// Bytes of a row of so many pixels.
    fn row_bytes(self, width: usize) -> usize {
        match self {
            Layout::Gray8 | Layout::Bayer(_) => width,
            Layout::Gray16 => 2 * width,
            Layout::Colour(bytes, _) => bytes * width,
            Layout::Yuv422(..) => 4 * width.div_ceil(2),
        }
    }
}

/// The image as a PNG.
///
/// # Errors
/// [`RawImageError`].
pub fn png_of(image: &Image<'_>) -> Result<Vec<u8>, RawImageError> {
    let layout =
        Layout::of(&image.encoding).ok_or_else(|| RawImageError::Encoding(image.encoding.clone()))?;
    let (width, height, step) = (image.width as usize, image.height as usize, image.step as usize);
    let row_bytes = layout.row_bytes(width);
    let fits = width > 0
        && height > 0
        && step >= row_bytes
        && (height - 1).checked_mul(step).and_then(|start| start.checked_add(row_bytes))
            <= Some(image.data.len());
    if !fits {
        return Err(RawImageError::Size {
            width: image.width,
            height: image.height,
            encoding: image.encoding.clone(),
            step: image.step,
            bytes: image.data.len(),
        });
    }
    let rows: Vec<&[u8]> = (0..height).map(|y| &image.data[y * step..y * step + row_bytes]).collect();
    Ok(match layout {
        Layout::Gray8 => png_gray8(width, height, &rows.concat()),
        Layout::Gray16 => {
            let level = |pair: &[u8]| match image.is_bigendian {
                0 => u16::from_le_bytes([pair[0], pair[1]]),
                _ => u16::from_be_bytes([pair[0], pair[1]]),
            };
            let levels: Vec<u16> = rows.iter().flat_map(|row| row.chunks_exact(2).map(level)).collect();
            png_gray16(width, height, &levels)
        }
        Layout::Colour(bytes, rgb) => {
            let pixels = rows.iter().flat_map(|row| row.chunks_exact(bytes));
            png_rgb8(width, height, &pixels.flat_map(|pixel| rgb.map(|at| pixel[at])).collect::<Vec<u8>>())
        }
        Layout::Yuv422(levels, cb, cr) => {
            let two = |four: &[u8]| levels.map(|at| rgb_of_yuv(four[at], four[cb], four[cr])).concat();
            let row = |row: &&[u8]| row.chunks_exact(4).flat_map(two).take(3 * width).collect::<Vec<u8>>();
            png_rgb8(width, height, &rows.iter().flat_map(row).collect::<Vec<u8>>())
        }
        Layout::Bayer(pattern) => png_rgb8(width, height, &demosaiced(&rows, width, pattern)),
    })
}

/// Of ITU-R BT.601 with levels of 16 to 235, as cameras and OpenCV have it.
fn rgb_of_yuv(level: u8, cb: u8, cr: u8) -> [u8; 3] {
    let y = 1.164 * (f32::from(level) - 16.0);
    let (cb, cr) = (f32::from(cb) - 128.0, f32::from(cr) - 128.0);
    [y + 1.596 * cr, y - 0.813 * cr - 0.391 * cb, y + 2.018 * cb].map(|v| v.round().clamp(0.0, 255.0) as u8)
}

/// Bilinear: each missing colour is the mean of the pixels of that colour that touch this one.
fn demosaiced(rows: &[&[u8]], width: usize, pattern: [[usize; 2]; 2]) -> Vec<u8> {
    let colour_at = |x: usize, y: usize| pattern[y % 2][x % 2];
    let mut rgb = Vec::with_capacity(3 * width * rows.len());
    for y in 0..rows.len() {
        for x in 0..width {
            let (mut sums, mut counts) = ([0_u32; 3], [0_u32; 3]);
            for (near_y, row) in rows.iter().enumerate().take(y + 2).skip(y.saturating_sub(1)) {
                for near_x in x.saturating_sub(1)..(x + 2).min(width) {
                    let colour = colour_at(near_x, near_y);
                    sums[colour] += u32::from(row[near_x]);
                    counts[colour] += 1;
                }
            }
            for colour in 0..3 {
                rgb.push(match (colour == colour_at(x, y), counts[colour]) {
                    (true, _) => rows[y][x],
                    // a picture of one row or column lacks a colour
                    (false, 0) => 0,
                    (false, count) => ((sums[colour] + count / 2) / count) as u8,
                });
            }
        }
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::imaging::{DecodeLimits, decode};

    /// The pixels of a two-by-two image, r, g, b each.
    fn pixels(encoding: &str, step: u32, is_bigendian: u8, data: &[u8]) -> Vec<[u8; 3]> {
        let image = Image {
            header: Default::default(),
            height: 2,
            width: 2,
            encoding: encoding.into(),
            is_bigendian,
            step,
            data,
        };
        let frame = decode(&png_of(&image).unwrap(), &DecodeLimits::default()).unwrap();
        frame.to_rgb8().chunks(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }

    #[test]
    fn each_encoding_gives_the_pixels_that_it_says() {
        let four = [[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]];
        // rows of seven bytes: the last one is passed over
        let rgb = [1, 2, 3, 4, 5, 6, 99, 7, 8, 9, 10, 11, 12, 99];
        let bgr = [3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10];
        let bgra = [3, 2, 1, 0, 6, 5, 4, 0, 9, 8, 7, 0, 12, 11, 10, 0];
        assert_eq!(pixels("rgb8", 7, 0, &rgb), four);
        assert_eq!(pixels("bgr8", 6, 0, &bgr), four);
        assert_eq!(pixels("bgra8", 8, 0, &bgra), four);
        let gray = [10, 20, 30, 40].map(|level| [level; 3]);
        assert_eq!(pixels("mono8", 2, 0, &[10, 20, 30, 40]), gray);
        assert_eq!(pixels("mono16", 4, 1, &[10, 10, 20, 20, 30, 30, 40, 40]), gray);
        assert_eq!(pixels("mono16", 4, 0, &[10, 10, 20, 20, 30, 30, 40, 40]), gray);
        // black and white without colour, then a red of OpenCV's
        let (uyvy, yuyv) = ([128, 16, 128, 235, 90, 81, 240, 81], [16, 128, 235, 128, 81, 90, 81, 240]);
        for converted in [pixels("yuv422", 4, 0, &uyvy), pixels("yuv422_yuy2", 4, 0, &yuyv)] {
            assert_eq!(converted[..2], [[0, 0, 0], [255, 255, 255]]);
            assert!(converted[2][0] > 250 && converted[2][1] < 5 && converted[2][2] < 5, "{converted:?}");
        }
    }

    #[test]
    fn a_mosaic_of_one_colour_becomes_that_colour_in_every_pattern() {
        for (encoding, data) in [
            ("bayer_rggb8", [200, 100, 100, 50]),
            ("bayer_bggr8", [50, 100, 100, 200]),
            ("bayer_gbrg8", [100, 50, 200, 100]),
            ("bayer_grbg8", [100, 200, 50, 100]),
        ] {
            assert_eq!(pixels(encoding, 2, 0, &data), [[200, 100, 50]; 4], "{encoding}");
        }
    }

    #[test]
    fn what_is_too_short_or_unknown_is_refused() {
        let image = |encoding: &str, step| Image {
            header: Default::default(),
            height: 2,
            width: 4,
            encoding: encoding.into(),
            is_bigendian: 0,
            step,
            data: &[0; 20],
        };
        assert!(png_of(&image("mono8", 4)).is_ok());
        assert!(matches!(png_of(&image("rgb8", 12)), Err(RawImageError::Size { bytes: 20, .. })));
        assert!(matches!(png_of(&image("mono8", 3)), Err(RawImageError::Size { step: 3, .. })));
        assert!(matches!(png_of(&image("mono8", u32::MAX)), Err(RawImageError::Size { .. })));
        let error = png_of(&image("32FC1", 16)).unwrap_err();
        assert!(error.to_string().contains("bayer"), "{error}");
    }
}
