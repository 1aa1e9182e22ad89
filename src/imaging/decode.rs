//! From bytes to a frame, under limits: JPEG, PNG, and the portable maps (PBM, PGM, PPM, PAM).
//!
//! Magic bytes decide the format; names and declared types are never asked. The size is read from the
//! header and held against the limits before any pixel is decoded. 16-bit samples become 0..=255 with
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

/// A family of files that is read here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Jpeg,
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

/// What the first bytes tell of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// The format, by its magic bytes.
    pub format: Format,
    /// Width after the orientation is applied.
    pub width_px: u32,
    /// Height after the orientation is applied.
    pub height_px: u32,
    /// Whether the file holds colour.
    pub colour: bool,
}

impl Header {
    /// The memory that the decoded [`Frame`] will hold: one `f32` plane, or four for a colour file.
    pub fn frame_bytes(&self) -> u64 {
        let planes = if self.colour { 4 } else { 1 };
        u64::from(self.width_px) * u64::from(self.height_px) * planes * size_of::<f32>() as u64
    }
}

/// Why bytes are not taken as a picture.
#[derive(Debug, Error)]
pub enum DecodeError {
    #[error("there are no bytes")]
    Empty,
    #[error("this is not a JPEG, PNG, PBM, PGM, PPM or PAM file of a kind that is read here")]
    UnknownFormat,
    #[error(
        "the picture is {width_px}×{height_px} px; at most {max_side_px} px a side and {max_pixels} px in all are taken"
    )]
    TooLarge { width_px: u32, height_px: u32, max_side_px: u32, max_pixels: u64 },
    #[error("decoding needs {needed_bytes} bytes of memory or more; {max_alloc_bytes} are allowed")]
    TooMuchMemory { needed_bytes: u64, max_alloc_bytes: u64 },
    #[error("the picture is cut off or damaged")]
    Corrupt { source: Box<dyn Error + Send + Sync> },
}

/// Read format and size, and hold them against the limits; no pixel is decoded.
pub fn read_header(bytes: &[u8], limits: &DecodeLimits) -> Result<Header, DecodeError> {
    opened(bytes, limits).map(|(_, header, _)| header)
}

/// Decode a picture into a frame.
pub fn decode(bytes: &[u8], limits: &DecodeLimits) -> Result<Frame, DecodeError> {
    let (decoder, header, orientation) = opened(bytes, limits)?;
    if header.format == Format::Jpeg && !jpeg_has_its_end(bytes) {
        return Err(DecodeError::Corrupt { source: "the end of the JPEG file is missing".into() });
    }
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|error| refused(error, limits))?;
    picture.apply_orientation(orientation);
    Ok(frame(picture))
}

/// Whether the end marker follows the first scan. The decoder paints what is missing gray and says nothing; a robot
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

/// A decoder that stands after the header, the header, and how the picture is to be turned.
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
    let too_long = width_px.max(height_px) > limits.max_side_px;
    if too_long || u64::from(width_px) * u64::from(height_px) > limits.max_pixels {
        let DecodeLimits { max_side_px, max_pixels, .. } = *limits;
        return Err(DecodeError::TooLarge { width_px, height_px, max_side_px, max_pixels });
    }
    if width_px == 0 || height_px == 0 {
        return Err(DecodeError::Corrupt { source: format!("the size is {width_px}×{height_px}").into() });
    }
    let needed_bytes = decoder.total_bytes();
    if needed_bytes > limits.max_alloc_bytes {
        return Err(DecodeError::TooMuchMemory { needed_bytes, max_alloc_bytes: limits.max_alloc_bytes });
    }
    let orientation = decoder.orientation().map_err(|error| refused(error, limits))?;
    let colour = decoder.color_type().has_color();
    let (width_px, height_px) = match orientation {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => (height_px, width_px),
        _ => (width_px, height_px),
    };
    Ok((decoder, Header { format, width_px, height_px, colour }, orientation))
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

/// Interleaved samples to one or three planes of grey levels, over black where there is alpha.
fn planes<T: Copy>(samples: &[T], colour: bool, alpha: bool, level: impl Fn(T) -> f32) -> Vec<Vec<f32>> {
    let channels = if colour { 3 } else { 1 };
    let stride = channels + usize::from(alpha);
    (0..channels)
        .map(|channel| match alpha {
            false => samples.iter().skip(channel).step_by(stride).map(|&v| level(v)).collect(),
            true => {
                samples.chunks_exact(stride).map(|p| level(p[channel]) * level(p[channels]) / 255.0).collect()
            }
        })
        .collect()
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
