//! From bytes to a frame, under limits: JPEG, PNG, and the portable maps (PBM, PGM, PPM, PAM).
//!
//! Magic bytes decide the format; names and declared types don't count. The size in the header is checked against the
//! limits before any pixel is decoded. 16-bit samples become 0..=255 with
//! their fraction; alpha is laid over black; the orientation in EXIF is applied, in the header's size too.

use std::error::Error;
use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use thiserror::Error;

use super::{Frame, Image};

/// What a picture may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeLimits {
    /// Longest side.
    pub max_side_px: u32,
    /// Largest area.
    pub max_pixels: u64,
    /// Most memory that the decoder may take for the picture and for its own buffers.
    pub max_alloc_bytes: u64,
}

impl Default for DecodeLimits {
    /// 8192 px a side; 40 megapixels; 256 MiB, which holds 40 Mpx of 8-bit colour twice.
    fn default() -> Self {
        DecodeLimits { max_side_px: 8192, max_pixels: 40_000_000, max_alloc_bytes: 256 << 20 }
    }
}

/// A file format that is read here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// JPEG.
    Jpeg,
    /// PNG.
    Png,
    /// PBM, PGM, PPM and PAM.
    Pnm,
}

impl Format {
    /// The media type under which such a file is sent.
    pub fn media_type(self) -> &'static str {
        match self {
            Format::Jpeg => "image/jpeg",
            Format::Png => "image/png",
            Format::Pnm => "image/x-portable-anymap",
        }
    }

    fn of(bytes: &[u8]) -> Option<Format> {
        match bytes {
            [0xff, 0xd8, 0xff, ..] => Some(Format::Jpeg),
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Format::Png),
            [b'P', b'1'..=b'7', separator, ..] if separator.is_ascii_whitespace() || *separator == b'#' => {
                Some(Format::Pnm)
            }
            _ => None,
        }
    }
}

/// The format and size of a picture, from its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The format, by its magic bytes.
    pub format: Format,
    /// Width as stored: the decoded [`Frame`] has width and height exchanged when the file says it lies on its side.
    pub width_px: u32,
    /// Height as stored.
    pub height_px: u32,
    /// Whether the file holds colour.
    pub colour: bool,
    /// Bits a sample as decoded: 8 or 16; fewer than 8 become 8.
    pub bits: u8,
}

/// Planes of `f32` that finding interest points holds at most: smoothed, gradient x and y, three of edges, the map.
const WORKING_PLANES: u64 = 7;

/// Planes of `f32` that a depth map holds at most for each of its two pictures: forty for one, at full size, where the
/// blur is so small that nothing is halved (some ten for registration and brightness, some sixty for filters, their
/// products and windows, some ten for what is judged).
const DEPTH_PLANES: u64 = 40;

impl Header {
    /// The memory that the picture takes while it is decoded and worked on: 8-bit samples as decoded, the [`Frame`]
    /// (one `f32` plane, or four for a colour file), and the planes of attention.
    pub fn working_bytes(&self) -> u64 {
        self.bytes_with(WORKING_PLANES)
    }

    /// The same for one of the two pictures that a depth map is made of.
    pub fn depth_bytes(&self) -> u64 {
        self.bytes_with(DEPTH_PLANES)
    }

    /// Samples as decoded, the frame, and so many planes more.
    fn bytes_with(&self, more_planes: u64) -> u64 {
        let (samples, planes) = if self.colour { (3, 4) } else { (1, 1) };
        let bytes_per_pixel = samples + size_of::<f32>() as u64 * (planes + more_planes);
        u64::from(self.width_px) * u64::from(self.height_px) * bytes_per_pixel
    }
}

/// Why bytes are not taken as a picture.
#[derive(Debug, Error)]
pub enum DecodeError {
    /// No bytes at all.
    #[error("there are no bytes")]
    Empty,
    /// Magic bytes of no format that is read here.
    #[error("this is not a JPEG, PNG, PBM, PGM, PPM or PAM file of a kind that is read here")]
    UnknownFormat,
    /// More pixels than the limits allow.
    #[error(
        "the picture is {width_px}×{height_px} px; at most {max_side_px} px a side and {max_pixels} px in all are taken"
    )]
    TooLarge {
        /// Width by the header.
        width_px: u32,
        /// Height by the header.
        height_px: u32,
        /// [`DecodeLimits::max_side_px`].
        max_side_px: u32,
        /// [`DecodeLimits::max_pixels`].
        max_pixels: u64,
    },
    /// More memory than the limits allow.
    #[error("decoding needs {needed_bytes} bytes of memory or more; {max_alloc_bytes} are allowed")]
    TooMuchMemory {
        /// What the decoder needs at least.
        needed_bytes: u64,
        /// [`DecodeLimits::max_alloc_bytes`].
        max_alloc_bytes: u64,
    },
    /// A file of a known format that can't be decoded.
    #[error("the picture is cut off or damaged")]
    Corrupt {
        /// The decoder's reason.
        source: Box<dyn Error + Send + Sync>,
    },
}

/// Reads format and size, and checks them against the limits; decodes and unpacks nothing.
///
/// # Errors
/// [`DecodeError`].
pub fn read_header(bytes: &[u8], limits: &DecodeLimits) -> Result<Header, DecodeError> {
    // The chunks between a PNG's size and its pixels may be long and compressed: the decoder would read them now.
    let Some(header) = png_header(bytes) else { return opened(bytes, limits).map(|(_, header, _)| header) };
    within(header.width_px, header.height_px, limits)?;
    Ok(header)
}

/// The first chunk of a PNG file: it must hold the size, and stand at a fixed place.
fn png_header(bytes: &[u8]) -> Option<Header> {
    const COLOUR_TYPES: [u8; 3] = [2, 3, 6]; // true colour, palette, true colour with alpha
    let chunk = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR")?;
    let (width, rest) = chunk.split_first_chunk()?;
    let (height, rest) = rest.split_first_chunk()?;
    let colour = rest.get(1).is_some_and(|kind| COLOUR_TYPES.contains(kind));
    let bits = if rest.first() == Some(&16) { 16 } else { 8 };
    let (width_px, height_px) = (u32::from_be_bytes(*width), u32::from_be_bytes(*height));
    Some(Header { format: Format::Png, width_px, height_px, colour, bits })
}

/// Checks a size against the limits.
fn within(width_px: u32, height_px: u32, limits: &DecodeLimits) -> Result<(), DecodeError> {
    let too_long = width_px.max(height_px) > limits.max_side_px;
    if too_long || u64::from(width_px) * u64::from(height_px) > limits.max_pixels {
        let DecodeLimits { max_side_px, max_pixels, .. } = *limits;
        return Err(DecodeError::TooLarge { width_px, height_px, max_side_px, max_pixels });
    }
    if width_px == 0 || height_px == 0 {
        return Err(DecodeError::Corrupt { source: format!("the size is {width_px}×{height_px}").into() });
    }
    Ok(())
}

/// Decodes a picture into a frame.
///
/// # Errors
/// [`DecodeError`].
pub fn decode(bytes: &[u8], limits: &DecodeLimits) -> Result<Frame, DecodeError> {
    let (decoder, header, orientation) = opened(bytes, limits)?;
    if header.format == Format::Jpeg && !jpeg_has_its_end(bytes) {
        return Err(DecodeError::Corrupt { source: "the end of the JPEG file is missing".into() });
    }
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|error| refused(error, limits))?;
    picture.apply_orientation(orientation);
    Ok(frame(picture))
}

/// Whether the end marker follows the first scan. The decoder fills what is missing with gray, without an error; a robot
/// must not take that for a place.
fn jpeg_has_its_end(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    // Segments with a length come before the first scan; one of them may hold a thumbnail with an end of its own.
    let mut rest = &bytes[2..];
    while let [0xff, marker, length_high, length_low, ..] = *rest {
        let length = match marker {
            0xff => 1,
            0x01 | 0xd0..=0xd7 => 2,
            _ => 2 + usize::from(u16::from_be_bytes([length_high, length_low])),
        };
        rest = rest.get(length..).unwrap_or_default();
        if marker == START_OF_SCAN {
            break;
        }
    }
    // In a scan every 0xff is followed by 0x00 or a marker, so the end can't be mistaken.
    rest.windows(2).any(|pair| pair == END_OF_IMAGE)
}

/// A decoder that has read the header, the header, and the orientation of the picture.
fn opened<'a>(
    bytes: &'a [u8],
    limits: &DecodeLimits,
) -> Result<(impl ImageDecoder + 'a, Header, Orientation), DecodeError> {
    if bytes.is_empty() {
        return Err(DecodeError::Empty);
    }
    let format = Format::of(bytes).ok_or(DecodeError::UnknownFormat)?;
    let mut reader = ImageReader::with_format(
        Cursor::new(bytes),
        match format {
            Format::Jpeg => ImageFormat::Jpeg,
            Format::Png => ImageFormat::Png,
            Format::Pnm => ImageFormat::Pnm,
        },
    );
    let mut allocation = Limits::no_limits();
    allocation.max_alloc = Some(limits.max_alloc_bytes);
    reader.limits(allocation);
    let mut decoder = reader.into_decoder().map_err(|error| refused(error, limits))?;

    let (width_px, height_px) = decoder.dimensions();
    within(width_px, height_px, limits)?;
    let needed_bytes = decoder.total_bytes();
    if needed_bytes > limits.max_alloc_bytes {
        return Err(DecodeError::TooMuchMemory { needed_bytes, max_alloc_bytes: limits.max_alloc_bytes });
    }
    let orientation = decoder.orientation().map_err(|error| refused(error, limits))?;
    let samples = decoder.color_type();
    let bits = if samples.bytes_per_pixel() > samples.channel_count() { 16 } else { 8 };
    let header = Header { format, width_px, height_px, colour: samples.has_color(), bits };
    Ok((decoder, header, orientation))
}

fn refused(error: ImageError, limits: &DecodeLimits) -> DecodeError {
    match error {
        ImageError::Limits(_) => DecodeError::TooMuchMemory {
            needed_bytes: limits.max_alloc_bytes.saturating_add(1),
            max_alloc_bytes: limits.max_alloc_bytes,
        },
        ImageError::Unsupported(_) => DecodeError::UnknownFormat,
        error => DecodeError::Corrupt { source: Box::new(error) },
    }
}

fn frame(picture: DynamicImage) -> Frame {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let (colour, alpha) = (picture.color().has_color(), picture.color().has_alpha());
    let eight = |v: u8| f32::from(v);
    let sixteen = |v: u16| f32::from(v) / 257.0; // 65535 / 255
    let planes = match &picture {
        DynamicImage::ImageLuma8(p) => planes(p.as_raw(), colour, alpha, eight),
        DynamicImage::ImageLumaA8(p) => planes(p.as_raw(), colour, alpha, eight),
        DynamicImage::ImageRgb8(p) => planes(p.as_raw(), colour, alpha, eight),
        DynamicImage::ImageRgba8(p) => planes(p.as_raw(), colour, alpha, eight),
        DynamicImage::ImageLuma16(p) => planes(p.as_raw(), colour, alpha, sixteen),
        DynamicImage::ImageLumaA16(p) => planes(p.as_raw(), colour, alpha, sixteen),
        DynamicImage::ImageRgb16(p) => planes(p.as_raw(), colour, alpha, sixteen),
        DynamicImage::ImageRgba16(p) => planes(p.as_raw(), colour, alpha, sixteen),
        // floating-point pictures come from none of the formats above
        other => planes(other.to_rgba8().as_raw(), true, true, eight),
    };
    let mut planes = planes.into_iter().map(|pixels| Image::new(width, height, pixels));
    match (planes.next(), planes.next(), planes.next()) {
        (Some(red), Some(green), Some(blue)) => Frame::colour([red, green, blue]),
        (Some(gray), ..) => Frame::gray(gray),
        _ => unreachable!("a picture has one plane or three"),
    }
}

/// Interleaved samples to one or three planes of gray levels, over black where there is alpha.
fn planes<T: Copy>(samples: &[T], colour: bool, alpha: bool, level: impl Fn(T) -> f32) -> Vec<Vec<f32>> {
    match (colour, alpha) {
        (false, false) => vec![plane::<T, 1>(samples, |[v]| level(v))],
        (false, true) => vec![plane::<T, 2>(samples, |[v, a]| level(v) * level(a) / 255.0)],
        (true, false) => (0..3).map(|c| plane::<T, 3>(samples, |rgb| level(rgb[c]))).collect(),
        (true, true) => {
            (0..3).map(|c| plane::<T, 4>(samples, |rgba| level(rgba[c]) * level(rgba[3]) / 255.0)).collect()
        }
    }
}

/// One plane from pixels of `N` samples: their number is known, so that the loop is a tight one.
fn plane<T: Copy, const N: usize>(samples: &[T], level: impl Fn([T; N]) -> f32) -> Vec<f32> {
    samples.as_chunks::<N>().0.iter().map(|&pixel| level(pixel)).collect()
}

#[cfg(test)]
mod tests {
    use image::codecs::jpeg::JpegEncoder;
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};
    use proptest::prelude::*;

    use super::*;
    use crate::imaging::encode;

    const LIMITS: DecodeLimits =
        DecodeLimits { max_side_px: 8192, max_pixels: 40_000_000, max_alloc_bytes: 256 << 20 };

    fn png(width: u32, height: u32, samples: &[u8], colour: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes).write_image(samples, width, height, colour).unwrap();
        bytes
    }

    /// A gray JPEG, left half dark and right half bright, with an EXIF orientation.
    fn jpeg(width: u32, height: u32, orientation: Option<u8>) -> Vec<u8> {
        let pixels: Vec<u8> =
            (0..width * height).map(|i| if i % width < width / 2 { 20 } else { 220 }).collect();
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
        if let Some(orientation) = orientation {
            let exif =
                [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"[..], &[orientation, 0, 0, 0, 0, 0, 0, 0]];
            encoder.set_exif_metadata(exif.concat()).unwrap();
        }
        encoder.write_image(&pixels, width, height, ExtendedColorType::L8).unwrap();
        bytes
    }

    fn samples() -> Vec<Vec<u8>> {
        let colours: Vec<u8> = (0..16 * 9 * 3).map(|i| (i * 37 % 251) as u8).collect();
        vec![
            jpeg(33, 17, Some(6)),
            encode::png_rgb8(16, 9, &colours),
            png(16, 9, &colours[..16 * 9 * 2], ExtendedColorType::L16),
            [b"P6 16 9 255\n", &colours[..]].concat(),
            [b"P5 16 9 65535\n", &colours[..16 * 9 * 2]].concat(),
            [b"P4 16 9\n", &colours[..2 * 9]].concat(),
            b"P2 3 2 15\n0 1 2 3 4 15\n".to_vec(),
            [
                &b"P7\nWIDTH 4\nHEIGHT 3\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n"[..],
                &colours[..48],
            ]
            .concat(),
        ]
    }

    #[test]
    fn portable_maps_are_read_at_every_depth() {
        let gray = |bytes: &[u8]| decode(bytes, &LIMITS).unwrap().luminance.pixels().to_vec();
        assert_eq!(gray(b"P5 2 1 255\n\x00\xff"), [0.0, 255.0]);
        assert_eq!(gray(b"P2 3 1 15\n0 5 15\n"), [0.0, 85.0, 255.0]);
        assert_eq!(gray(b"P4 3 1\n\x40"), [255.0, 0.0, 255.0]);
        assert_eq!(gray(b"P1 # drawn\n2 1\n1 0\n"), [0.0, 255.0]);
        let sixteen = gray(b"P5 2 1 65535\n\x80\x00\x00\x01");
        assert!((sixteen[0] - 32768.0 / 257.0).abs() < 1e-4 && (sixteen[1] - 1.0 / 257.0).abs() < 1e-6);
        let colour = decode(b"P6 1 1 255\n\x01\x02\x03", &LIMITS).unwrap();
        assert_eq!(colour.to_rgb8(), [1, 2, 3]);
    }

    #[test]
    fn sixteen_bits_keep_their_fraction() {
        let samples: Vec<u8> = [1u16, 256, 65535].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let frame = decode(&png(3, 1, &samples, ExtendedColorType::L16), &LIMITS).unwrap();
        for (level, expected) in frame.luminance.pixels().iter().zip([1.0 / 257.0, 256.0 / 257.0, 255.0]) {
            assert!((level - expected).abs() < 1e-5, "{level} is not {expected}");
        }
    }

    #[test]
    fn alpha_lies_over_black() {
        let colour = png(2, 1, &[200, 100, 50, 255, 200, 100, 50, 51], ExtendedColorType::Rgba8);
        assert_eq!(decode(&colour, &LIMITS).unwrap().to_rgb8(), [200, 100, 50, 40, 20, 10]);
        let gray = png(2, 1, &[200, 0, 200, 255], ExtendedColorType::La8);
        assert_eq!(decode(&gray, &LIMITS).unwrap().luminance.pixels(), [0.0, 200.0]);
    }

    #[test]
    fn the_orientation_of_exif_is_applied_when_decoding() {
        // 6: the camera was turned; the picture is to be turned a quarter clockwise
        let bytes = jpeg(48, 16, Some(6));
        let header = read_header(&bytes, &LIMITS).unwrap();
        assert_eq!((header.format, header.width_px, header.height_px), (Format::Jpeg, 48, 16));
        let frame = decode(&bytes, &LIMITS).unwrap();
        assert_eq!((frame.width(), frame.height()), (16, 48));
        assert!(frame.luminance.at(8, 4) < 60.0 && frame.luminance.at(8, 44) > 180.0);
        let upright = decode(&jpeg(48, 16, None), &LIMITS).unwrap();
        assert!(upright.luminance.at(4, 8) < 60.0 && upright.luminance.at(44, 8) > 180.0);
    }

    #[test]
    fn header_and_frame_agree() {
        for bytes in samples() {
            let header = read_header(&bytes, &LIMITS).unwrap();
            let frame = decode(&bytes, &LIMITS).unwrap();
            // One of the samples lies on its side, so that width and height change places.
            let stored = (header.width_px as usize, header.height_px as usize);
            let decoded = (frame.width(), frame.height());
            assert!(stored == decoded || stored == (decoded.1, decoded.0), "{stored:?} {decoded:?}");
            assert_eq!(header.colour, frame.is_colour());
            let planes = if frame.is_colour() { 4 } else { 1 };
            assert!(header.working_bytes() > (frame.width() * frame.height() * planes * 4) as u64);
        }
    }

    #[test]
    fn the_header_tells_bits_a_sample() {
        let bits = |bytes: &[u8]| read_header(bytes, &LIMITS).unwrap().bits;
        assert_eq!(bits(&png(1, 1, &[0, 0], ExtendedColorType::L16)), 16);
        assert_eq!(bits(&png(1, 1, &[0, 0, 0], ExtendedColorType::Rgb8)), 8);
        assert_eq!((bits(b"P5 1 1 65535\n\0\0"), bits(b"P5 1 1 255\n\0"), bits(b"P4 1 1\n\0")), (16, 8, 8));
        assert_eq!(bits(&jpeg(8, 8, None)), 8);
    }

    #[test]
    fn what_is_no_picture_is_told_so() {
        assert!(matches!(decode(b"", &LIMITS), Err(DecodeError::Empty)));
        for bytes in [&b"GIF89a\x01\0\x01\0"[..], b"hello", b"P", b"P5", b"P9 1 1", b"\xff\xd8"] {
            assert!(matches!(decode(bytes, &LIMITS), Err(DecodeError::UnknownFormat)), "{bytes:?}");
        }
        let cut = &encode::png_gray8(64, 64, &[7; 64 * 64])[..60];
        assert!(matches!(decode(cut, &LIMITS), Err(DecodeError::Corrupt { .. })));
        assert!(matches!(decode(b"P5 0 4 255\n", &LIMITS), Err(DecodeError::Corrupt { .. })));
    }

    #[test]
    fn a_giant_is_refused_by_its_header() {
        let refused = |bytes: &[u8]| match (read_header(bytes, &LIMITS), decode(bytes, &LIMITS)) {
            (
                Err(DecodeError::TooLarge { width_px, height_px, .. }),
                Err(DecodeError::TooLarge { width_px: w, height_px: h, .. }),
            ) => {
                assert_eq!((width_px, height_px), (w, h));
                (w, h)
            }
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(b"P5 60000 60000 255\n"), (60_000, 60_000));
        assert_eq!(refused(b"P5 8193 1 255\n"), (8193, 1));
        assert_eq!(refused(b"P5 8000 8000 255\n"), (8000, 8000));
        // the size in a PNG's header, its checksum put right
        let mut giant = encode::png_gray8(1, 1, &[0]);
        giant[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
        let checksum = crc(&giant[12..29]).to_be_bytes();
        giant[29..33].copy_from_slice(&checksum);
        assert_eq!(refused(&giant), (60_000, 60_000));
    }

    #[test]
    fn memory_is_held_to_its_limit() {
        let limits = DecodeLimits { max_alloc_bytes: 1000, ..LIMITS };
        for bytes in [&b"P5 40 40 255\n"[..], &encode::png_gray8(40, 40, &[0; 1600]), &jpeg(40, 40, None)] {
            assert!(matches!(decode(bytes, &limits), Err(DecodeError::TooMuchMemory { .. })), "{bytes:?}");
        }
    }

    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |crc, &byte| {
            (0..8)
                .fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
        })
    }

    #[test]
    fn a_cut_at_any_byte_is_an_error_or_a_picture() {
        for bytes in samples() {
            for end in 0..bytes.len() {
                if let Ok(frame) = decode(&bytes[..end], &LIMITS) {
                    assert!(frame.luminance.pixels().iter().all(|v| v.is_finite()));
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn no_bytes_make_it_panic(
            which in 0usize..8,
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
            tail in prop::collection::vec(any::<u8>(), 0..8),
        ) {
            let mut bytes = samples().swap_remove(which);
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            bytes.extend(tail);
            let limits = DecodeLimits { max_side_px: 512, max_pixels: 1 << 16, max_alloc_bytes: 1 << 20 };
            if let Ok(frame) = decode(&bytes, &limits) {
                prop_assert!(frame.luminance.pixels().iter().all(|v| (0.0..=255.001).contains(v)));
            }
        }
    }
}

#[cfg(test)]
mod cut_off {
    use image::codecs::jpeg::JpegEncoder;
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    use super::*;

    fn chequered() -> Vec<u8> {
        (0..48 * 32).map(|i| if (i % 48 / 4 + i / 48 / 4) % 2 == 0 { 200 } else { 30 }).collect()
    }

    fn refuses_every_shorter_file(whole: &[u8]) {
        let limits = DecodeLimits::default();
        assert!(decode(whole, &limits).is_ok());
        for length in 0..whole.len() {
            assert!(decode(&whole[..length], &limits).is_err(), "{length} of {} bytes", whole.len());
        }
    }

    #[test]
    fn a_jpeg_without_its_end_is_refused_wherever_it_was_cut() {
        let mut file = Vec::new();
        JpegEncoder::new(&mut file).encode(&chequered(), 48, 32, ExtendedColorType::L8).unwrap();
        refuses_every_shorter_file(&file);
    }

    #[test]
    fn a_jpeg_with_a_tail_of_padding_is_whole() {
        let mut file = Vec::new();
        JpegEncoder::new(&mut file).encode(&chequered(), 48, 32, ExtendedColorType::L8).unwrap();
        file.extend([0; 100]);
        assert!(decode(&file, &DecodeLimits::default()).is_ok());
    }

    #[test]
    fn a_png_without_its_pixels_is_refused() {
        let mut file = Vec::new();
        PngEncoder::new(&mut file).write_image(&chequered(), 48, 32, ExtendedColorType::L8).unwrap();
        // The closing chunk says nothing about pixels: 12 bytes that may be missing.
        let limits = DecodeLimits::default();
        for length in 0..file.len() - 16 {
            assert!(decode(&file[..length], &limits).is_err(), "{length} of {} bytes", file.len());
        }
    }
}
