//! From bytes to a frame, under limits: JPEG, PNG, and the portable maps (PBM, PGM, PPM, PAM).
//!
//! Magic bytes decide the format; names and declared types don't count. The size in the header is checked against the
//! limits before any pixel is decoded. 16-bit samples become 0..=255 with
//! their fraction; alpha is laid over black; the orientation in EXIF is applied, in the header's size too.
//!
//! Where less is needed than a picture holds, [`decode_reduced`] decodes to the smaller size at once.

use std::error::Error;
use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use jpeg_decoder::PixelFormat;
use memchr::memmem;
use pulp::{Arch, Simd, WithSimd};
use thiserror::Error;

use super::reduction::{Reduction, reduced_size};
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
    /// 8192 px a side; 50 megapixels, so that a phone's picture of 8064×6048 px is taken; 288 MiB, which holds 50 Mpx of
    /// 8-bit colour twice.
    fn default() -> Self {
        DecodeLimits { max_side_px: 8192, max_pixels: 50_000_000, max_alloc_bytes: 288 << 20 }
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

/// Planes of `f32` that a segmentation holds at most: two of colour, three of differences, one of their ratio to the
/// offset, three while a noisy ground is averaged, and its masks.
const SEGMENTATION_PLANES: u64 = 10;

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

    /// The same for a picture that is segmented.
    pub fn segmentation_bytes(&self) -> u64 {
        self.bytes_with(SEGMENTATION_PLANES)
    }

    /// The same for one of the two pictures that a depth map is made of.
    pub fn depth_bytes(&self) -> u64 {
        self.bytes_with(DEPTH_PLANES)
    }

    /// The memory that the picture takes while it is brought down by [`decode_reduced`] and worked on: samples of the
    /// stored size, an alpha channel counted in (for a JPEG those of 8 bits and the 16-bit coefficients, which is what a
    /// progressive one takes; others stay far below), then the [`Frame`] and the planes of attention at the reduced size.
    pub fn reduced_bytes(&self, longer_side_px: usize) -> u64 {
        const COEFFICIENT_BYTES: u64 = size_of::<i16>() as u64;
        let (width, height) = (self.width_px as usize, self.height_px as usize);
        let (reduced_width, reduced_height) =
            reduced_size(width, height, longer_side_px).unwrap_or((width, height));
        let (colours, planes) = if self.colour { (3, 4) } else { (1, 1) };
        let stored_bytes_per_pixel = match self.format {
            Format::Jpeg => colours * (1 + COEFFICIENT_BYTES),
            Format::Png | Format::Pnm => (colours + 1) * u64::from(self.bits / 8),
        };
        let stored_pixels = u64::from(self.width_px) * u64::from(self.height_px);
        let reduced_pixels = reduced_width as u64 * reduced_height as u64;
        stored_pixels * stored_bytes_per_pixel
            + reduced_pixels * size_of::<f32>() as u64 * (planes + WORKING_PLANES)
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
    if header.format == Format::Jpeg {
        scans_of_whole_jpeg(bytes)?;
    }
    decoded(decoder, orientation, limits)
}

/// The frame at the stored size.
fn decoded(
    decoder: impl ImageDecoder,
    orientation: Orientation,
    limits: &DecodeLimits,
) -> Result<Frame, DecodeError> {
    let mut picture = DynamicImage::from_decoder(decoder).map_err(|error| refused(error, limits))?;
    picture.apply_orientation(orientation);
    Ok(frame(&picture, None))
}

/// Decodes a picture into a frame whose longer side is at most `longer_side_px` (1 at least), with
/// [`Frame::reduction`] set: what [`decode`] and [`Frame::at_most`] give, in less time and memory.
///
/// Planes are made at the smaller size alone. A JPEG of four times the size or more is decoded at 1/2, 1/4 or 1/8, so that
/// its longer side is still twice `longer_side_px`: on photographs its gray levels differ from the exact mean by about one
/// (root mean square), by more where fine, saturated texture fills a small picture. Smaller ones, other formats, and the
/// few kinds of JPEG that the reducing decoder doesn't take (CMYK, those with Adobe's colour marker, those of very many
/// scans) are decoded in full and then averaged.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_reduced(
    bytes: &[u8],
    limits: &DecodeLimits,
    longer_side_px: usize,
) -> Result<Frame, DecodeError> {
    let (decoder, header, orientation) = opened(bytes, limits)?;
    let scans = match header.format {
        Format::Jpeg => Some(scans_of_whole_jpeg(bytes)?),
        Format::Png | Format::Pnm => None,
    };
    let (width, height) = (header.width_px as usize, header.height_px as usize);
    let Some(to) = reduced_size(width, height, longer_side_px) else {
        return decoded(decoder, orientation, limits);
    };
    let (picture, divisor) =
        match scans.and_then(|scans| reduced_jpeg(bytes, &scans, &header, longer_side_px)) {
            Some((picture, divisor)) => (picture, divisor as f64),
            None => (DynamicImage::from_decoder(decoder).map_err(|error| refused(error, limits))?, 1.0),
        };
    // The last column and row of a reduced JPEG may lie outside of the posted picture in part.
    let reduction = Reduction::new(width as f64 / divisor, height as f64 / divisor, to);
    let reduced = oriented(frame(&picture, Some(&reduction)), orientation);
    Ok(Frame { reduction: width.max(height) as f32 / to.0.max(to.1) as f32, ..reduced })
}

/// A JPEG decoded at 1/divisor of its size, rounded up, and the divisor: the largest of 8, 4 and 2 that leaves its longer
/// side at twice `longer_side_px` or more. Not turned. `None` if there is none, or if the reducing decoder doesn't take the
/// file as what the header says.
fn reduced_jpeg(
    bytes: &[u8],
    scans: &Scans<'_>,
    header: &Header,
    longer_side_px: usize,
) -> Option<(DynamicImage, u32)> {
    /// A reduced decoding is sharper than a mean over the area, and its colours have half the resolution. At twice the
    /// size and more, the mean that follows evens that out: on photographs about 1 gray level of difference (root mean square)
    /// instead of 2 to 6.
    const FINER_BY: u64 = 2;
    /// Encoders write some ten. The reducing decoder takes any number, and each may cost a pass over the picture.
    const MOST_MORE_SCANS: usize = 32;
    let many = memmem::find_iter(scans.after_first, &START_OF_SCAN).nth(MOST_MORE_SCANS).is_some();
    if many || scans.adobe {
        return None;
    }
    let longer = u64::from(header.width_px.max(header.height_px));
    let least = FINER_BY.saturating_mul(longer_side_px.max(1) as u64);
    let divisor =
        [8, 4, 2].into_iter().find(|&divisor| longer >= least.saturating_mul(u64::from(divisor)))?;
    let (width, height) = (header.width_px.div_ceil(divisor), header.height_px.div_ceil(divisor));

    let mut decoder = jpeg_decoder::Decoder::new(bytes);
    // It takes the smallest size at which one side is as long as asked: the longer one is to decide.
    let (width_asked, height_asked) = if width >= height { (width, u32::MAX) } else { (u32::MAX, height) };
    let side = |length: u32| u16::try_from(length).unwrap_or(u16::MAX);
    let size = decoder.scale(side(width_asked), side(height_asked)).ok()?;
    if size != (side(width), side(height)) {
        return None;
    }
    let samples = decoder.decode().ok()?;
    let picture = match (decoder.info()?.pixel_format, header.colour) {
        (PixelFormat::L8, false) => DynamicImage::ImageLuma8(ImageBuffer::from_raw(width, height, samples)?),
        (PixelFormat::RGB24, true) => DynamicImage::ImageRgb8(ImageBuffer::from_raw(width, height, samples)?),
        _ => return None,
    };
    Some((picture, divisor))
}

const START_OF_SCAN: [u8; 2] = [0xff, 0xda];

/// What a JPEG says before its first scan, and what follows the header of that.
struct Scans<'a> {
    after_first: &'a [u8],
    /// Whether a marker of Adobe's says how colours are stored.
    adobe: bool,
}

/// The scans of a JPEG whose end marker follows the first of them. The decoders fill what is missing with gray, without
/// an error; a robot must not take that for a place.
fn scans_of_whole_jpeg(bytes: &[u8]) -> Result<Scans<'_>, DecodeError> {
    const ADOBE: u8 = 0xee;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    // Segments with a length come before the first scan; one of them may hold a thumbnail with an end of its own.
    let mut rest = &bytes[2..];
    let mut adobe = false;
    while let [0xff, marker, length_high, length_low, ..] = *rest {
        let length = match marker {
            0xff => 1,
            0x01 | 0xd0..=0xd7 => 2,
            _ => 2 + usize::from(u16::from_be_bytes([length_high, length_low])),
        };
        rest = rest.get(length..).unwrap_or_default();
        adobe |= marker == ADOBE;
        if [0xff, marker] == START_OF_SCAN {
            break;
        }
    }
    // In a scan every 0xff is followed by 0x00 or a marker, so the end can't be mistaken.
    memmem::find(rest, &END_OF_IMAGE)
        .map(|_| Scans { after_first: rest, adobe })
        .ok_or_else(|| DecodeError::Corrupt { source: "the end of the JPEG file is missing".into() })
}

/// A frame as it lies in the file, turned as the file says.
fn oriented(frame: Frame, orientation: Orientation) -> Frame {
    if orientation == Orientation::NoTransforms {
        return frame;
    }
    let turned = |image: &Image| {
        let (right, bottom) = (image.width() - 1, image.height() - 1);
        let upright = |f: &dyn Fn(usize, usize) -> f32| Image::from_fn(right + 1, bottom + 1, f);
        let on_its_side = |f: &dyn Fn(usize, usize) -> f32| Image::from_fn(bottom + 1, right + 1, f);
        match orientation {
            Orientation::NoTransforms => image.clone(),
            Orientation::FlipHorizontal => upright(&|x, y| image.at(right - x, y)),
            Orientation::FlipVertical => upright(&|x, y| image.at(x, bottom - y)),
            Orientation::Rotate180 => upright(&|x, y| image.at(right - x, bottom - y)),
            Orientation::Rotate90 => on_its_side(&|x, y| image.at(y, bottom - x)),
            Orientation::Rotate270 => on_its_side(&|x, y| image.at(right - y, x)),
            Orientation::Rotate90FlipH => on_its_side(&|x, y| image.at(y, x)),
            Orientation::Rotate270FlipH => on_its_side(&|x, y| image.at(right - y, bottom - x)),
        }
    };
    Frame {
        luminance: turned(&frame.luminance),
        rgb: frame.rgb.as_ref().map(|planes| planes.each_ref().map(turned)),
        ..frame
    }
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

/// The frame of a decoded picture, or the reduced one.
fn frame(picture: &DynamicImage, reduction: Option<&Reduction>) -> Frame {
    let layout = Layout {
        width: picture.width() as usize,
        height: picture.height() as usize,
        colour: picture.color().has_color(),
        alpha: picture.color().has_alpha(),
    };
    let eight = |v: u8| f32::from(v);
    let sixteen = |v: u16| f32::from(v) / 257.0; // 65535 / 255
    match picture {
        DynamicImage::ImageLuma8(p) => layout.frame(p.as_raw(), reduction, eight),
        DynamicImage::ImageLumaA8(p) => layout.frame(p.as_raw(), reduction, eight),
        DynamicImage::ImageRgb8(p) => layout.frame(p.as_raw(), reduction, eight),
        DynamicImage::ImageRgba8(p) => layout.frame(p.as_raw(), reduction, eight),
        DynamicImage::ImageLuma16(p) => layout.frame(p.as_raw(), reduction, sixteen),
        DynamicImage::ImageLumaA16(p) => layout.frame(p.as_raw(), reduction, sixteen),
        DynamicImage::ImageRgb16(p) => layout.frame(p.as_raw(), reduction, sixteen),
        DynamicImage::ImageRgba16(p) => layout.frame(p.as_raw(), reduction, sixteen),
        // floating-point pictures come from none of the formats above
        other => {
            Layout { colour: true, alpha: true, ..layout }.frame(other.to_rgba8().as_raw(), reduction, eight)
        }
    }
}

/// How interleaved samples lie: rows of `width` pixels, each of one or three samples and perhaps alpha.
struct Layout {
    width: usize,
    height: usize,
    colour: bool,
    alpha: bool,
}

impl Layout {
    /// The frame of samples whose gray level is `level`, over black where there is alpha.
    fn frame<T: Copy>(
        &self,
        samples: &[T],
        reduction: Option<&Reduction>,
        level: impl Fn(T) -> f32,
    ) -> Frame {
        let over_black = |v: T, alpha: T| level(v) * level(alpha) / 255.0;
        let gray = |[plane]: [Image; 1]| Frame::gray(plane);
        match (self.colour, self.alpha) {
            (false, false) => gray(self.planes(samples, reduction, |[v]| [level(v)])),
            (false, true) => gray(self.planes(samples, reduction, |[v, a]| [over_black(v, a)])),
            (true, false) => Frame::colour(
                self.planes(samples, reduction, |[r, g, b]: [T; 3]| [level(r), level(g), level(b)]),
            ),
            (true, true) => Frame::colour(self.planes(samples, reduction, |[r, g, b, a]: [T; 4]| {
                [over_black(r, a), over_black(g, a), over_black(b, a)]
            })),
        }
    }

    /// `M` planes from pixels of `N` samples: their numbers are known, so that the loops are tight ones.
    fn planes<T: Copy, const N: usize, const M: usize>(
        &self,
        samples: &[T],
        reduction: Option<&Reduction>,
        levels: impl Fn([T; N]) -> [f32; M],
    ) -> [Image; M] {
        let pixels = samples.as_chunks::<N>().0;
        let Some(reduction) = reduction else {
            let mut planes = [(); M].map(|()| vec![0.0; pixels.len()]);
            Arch::new().dispatch(Apart { pixels, levels, planes: &mut planes });
            return planes.map(|plane| Image::new(self.width, self.height, plane));
        };
        reduction.planes(|y, weight, sums| {
            for (sums, &pixel) in sums.iter_mut().zip(&pixels[y * self.width..][..self.width]) {
                sums.iter_mut().zip(levels(pixel)).for_each(|(sum, level)| *sum += weight * level);
            }
        })
    }
}

/// Pixels that are taken apart together.
const TILE_PX: usize = 64;

/// Planes from interleaved pixels.
struct Apart<'a, T, F, const N: usize, const M: usize> {
    pixels: &'a [[T; N]],
    levels: F,
    planes: &'a mut [Vec<f32>; M],
}

impl<T: Copy, F: Fn([T; N]) -> [f32; M], const N: usize, const M: usize> WithSimd for Apart<'_, T, F, N, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let mut tile = [[0.0; TILE_PX]; M];
        for (number, pixels) in self.pixels.chunks(TILE_PX).enumerate() {
            for (at, &pixel) in pixels.iter().enumerate() {
                let levels = (self.levels)(pixel);
                for plane in 0..M {
                    tile[plane][at] = levels[plane];
                }
            }
            for (plane, tile) in self.planes.iter_mut().zip(&tile) {
                plane[number * TILE_PX..][..pixels.len()].copy_from_slice(&tile[..pixels.len()]);
            }
        }
    }
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
        DecodeLimits { max_side_px: 8192, max_pixels: 50_000_000, max_alloc_bytes: 288 << 20 };

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

    /// A colour JPEG of smooth waves, with an EXIF orientation.
    fn waves(width: u32, height: u32, orientation: u8) -> Vec<u8> {
        let level = |x: u32, y: u32, step: f32| {
            (128.0 + 100.0 * (x as f32 / step).sin() * (y as f32 / 23.0).cos()) as u8
        };
        let pixels: Vec<u8> = (0..width * height)
            .flat_map(|i| [17.0, 29.0, 41.0].map(|step| level(i % width, i / width, step)))
            .collect();
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
        let exif =
            [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"[..], &[orientation, 0, 0, 0, 0, 0, 0, 0]];
        encoder.set_exif_metadata(exif.concat()).unwrap();
        encoder.write_image(&pixels, width, height, ExtendedColorType::Rgb8).unwrap();
        bytes
    }

    /// Root mean square of the difference, over all planes.
    fn difference(a: &Frame, b: &Frame) -> f32 {
        assert_eq!((a.width(), a.height(), a.is_colour()), (b.width(), b.height(), b.is_colour()));
        assert_eq!(a.reduction, b.reduction);
        let planes = |frame: &Frame| -> Vec<f32> {
            let colours = frame.rgb.iter().flatten();
            std::iter::once(&frame.luminance).chain(colours).flat_map(Image::pixels).copied().collect()
        };
        let squares: Vec<f32> = planes(a).iter().zip(planes(b)).map(|(a, b)| (a - b).powi(2)).collect();
        (squares.iter().sum::<f32>() / squares.len() as f32).sqrt()
    }

    #[test]
    fn a_jpeg_decoded_smaller_is_the_whole_one_brought_down() {
        for (orientation, longer) in (1..=8).zip([75, 76, 37, 38, 20, 18, 50, 299]) {
            let bytes = waves(301, 203, orientation);
            let whole = decode(&bytes, &LIMITS).unwrap();
            let reduced = decode_reduced(&bytes, &LIMITS, longer).unwrap();
            let difference = difference(&reduced, &whole.at_most(longer));
            assert!(difference < 2.0, "orientation {orientation}, {longer} px: {difference}");
        }
        let gray = jpeg(400, 90, Some(3));
        let whole = decode(&gray, &LIMITS).unwrap();
        assert!(difference(&decode_reduced(&gray, &LIMITS, 45).unwrap(), &whole.at_most(45)) < 1.0);
    }

    #[test]
    fn other_files_are_decoded_smaller_without_a_difference() {
        for bytes in samples() {
            let whole = decode(&bytes, &LIMITS).unwrap();
            for longer in [1, 2, 7, 13, 16, 40] {
                let reduced = decode_reduced(&bytes, &LIMITS, longer).unwrap();
                let most = if bytes.starts_with(b"\xff\xd8") { 2.0 } else { 1e-3 };
                let difference = difference(&reduced, &whole.at_most(longer));
                assert!(difference < most, "{longer} px: {difference}");
            }
        }
    }

    #[test]
    fn a_smaller_jpeg_is_refused_as_the_whole_one_is() {
        let whole = waves(200, 100, 1);
        assert!(decode_reduced(&whole[..whole.len() / 2], &LIMITS, 20).is_err());
        let limits = DecodeLimits { max_pixels: 19_999, ..LIMITS };
        assert!(matches!(decode_reduced(&whole, &limits, 20), Err(DecodeError::TooLarge { .. })));
    }

    #[test]
    fn a_colour_marker_of_adobe_leaves_the_file_to_the_whole_decoder() {
        let jpeg = waves(160, 160, 1);
        // transform 0: the three planes are red, green and blue
        let marker = b"\xff\xee\0\x0eAdobe\0\x64\0\0\0\0\0";
        let bytes = [&jpeg[..2], &marker[..], &jpeg[2..]].concat();
        let whole = decode(&bytes, &LIMITS).unwrap();
        assert!(difference(&decode_reduced(&bytes, &LIMITS, 20).unwrap(), &whole.at_most(20)) < 1e-3);
    }

    #[test]
    fn a_picture_of_a_phone_is_taken_within_a_lane() {
        let phone = Header { format: Format::Jpeg, width_px: 8064, height_px: 6048, colour: true, bits: 8 };
        assert!(within(phone.width_px, phone.height_px, &DecodeLimits::default()).is_ok());
        // half of what all pictures being worked on may take
        assert!(phone.reduced_bytes(1280) < 512 << 20, "{}", phone.reduced_bytes(1280));
        assert!(phone.reduced_bytes(1280) < phone.working_bytes() / 4);
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
            for frame in [decode(&bytes, &limits), decode_reduced(&bytes, &limits, 8)].into_iter().flatten() {
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
