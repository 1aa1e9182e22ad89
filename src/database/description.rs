//! Descriptions of exemplars as they are kept for later trainings: windows, signatures, spectra and edge points, without
//! name and size, which the exemplar's row has.
//!
//! All numbers are little-endian: u32 of windows, of components of a signature, of numbers of a spectrum, of edge points,
//! and 1 for colour; f32, the unit of the signatures; then of the windows x, y and salience (f32 each), the levels (u8),
//! the signatures (i16, in units), the spectra (i8); of the edge points x, y and the gradient along both (f32 each).

use super::{ALGORITHM_REVISION, ExemplarRow};
use crate::store::{BlobName, DescriptionKey, InvalidBlobName};
use landmarkd_core::recognition::landmarks::{
    DescribedExemplar, EdgePoint, Exemplar, LandmarkOptions, Window,
};
use landmarkd_core::vision::InterestPoint;

/// Grows with every change of the layout above.
const LAYOUT: u32 = 1;
/// Signatures are kept in steps of their largest number, divided by this: steps of 3 · 10⁻⁵ at most, where components
/// of a signature are about 0.05 and distances between signatures of the same thing 0.3.
const STEPS: f32 = 32_767.0;

/// What the description of an exemplar's picture is known by.
///
/// # Errors
/// The row names no blob.
pub(crate) fn description_key(
    row: &ExemplarRow,
    options: &LandmarkOptions,
) -> Result<DescriptionKey, InvalidBlobName> {
    // Without `..`: of a new option it has to be said whether descriptions depend on it.
    let LandmarkOptions {
        method: _,
        viewpoint: _,
        operator,
        symmetry_radius_px,
        interest_points,
        query_points: _,
        subwindow_radii_px,
        rings,
        sectors,
        taper: _,
        normalise: _,
        colour,
        dimension: _,
        neighbours: _,
        epsilon: _,
        position_prior_px: _,
        per_label: _,
        signature,
        working_size_px,
        levels_per_octave,
        turn_prior_deg: _,
        false_alarms: _,
    } = options;
    let text = format!(
        "description {LAYOUT} {ALGORITHM_REVISION}\n{operator:?} {symmetry_radius_px} {interest_points} \
         {subwindow_radii_px:?} {rings} {sectors} {colour:?} {signature:?} {working_size_px:?} {levels_per_octave}\n"
    );
    Ok(DescriptionKey { picture: row.blob.parse()?, options: BlobName::of(text.as_bytes()) })
}

/// A description as it is kept.
pub(crate) fn encode(described: &DescribedExemplar) -> Vec<u8> {
    let DescribedExemplar { exemplar, windows, colour, signatures, spectra } = described;
    let of_each = |all: usize| all.checked_div(windows.len()).unwrap_or(0);
    let largest = signatures.iter().fold(0.0_f32, |most, number| most.max(number.abs()));
    let unit = if largest > 0.0 { largest / STEPS } else { 1.0 };
    let counts = [
        windows.len(),
        of_each(signatures.len()),
        of_each(spectra.len()),
        exemplar.edges.len(),
        usize::from(*colour),
    ];
    let mut bytes = Vec::new();
    bytes.extend(counts.iter().flat_map(|&count| (count as u32).to_le_bytes()));
    bytes.extend(unit.to_le_bytes());
    for Window { point, .. } in windows {
        bytes.extend([point.x_px, point.y_px, point.salience].iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes.extend(windows.iter().map(|window| window.radius));
    bytes.extend(signatures.iter().flat_map(|number| ((number / unit).round() as i16).to_le_bytes()));
    bytes.extend(spectra.iter().flat_map(|number| number.to_le_bytes()));
    for EdgePoint { x_px, y_px, gradient_x, gradient_y } in &exemplar.edges {
        bytes.extend([x_px, y_px, gradient_x, gradient_y].iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

/// The description that was kept of an exemplar's picture; `None` if the bytes are none.
pub(crate) fn decode(bytes: &[u8], row: &ExemplarRow) -> Option<DescribedExemplar> {
    let mut rest = Rest(bytes);
    let [windows, signature, spectrum, edges, colour] = *rest.numbers(5, u32::from_le_bytes)? else {
        return None;
    };
    let [windows, signature, spectrum, edges] =
        [windows, signature, spectrum, edges].map(|count| count as usize);
    let unit = *rest.numbers(1, f32::from_le_bytes)?.first()?;
    let points = rest.numbers(windows.checked_mul(3)?, f32::from_le_bytes)?;
    let radii = rest.numbers(windows, u8::from_le_bytes)?;
    let signatures = rest.numbers(windows.checked_mul(signature)?, i16::from_le_bytes)?;
    let spectra = rest.numbers(windows.checked_mul(spectrum)?, i8::from_le_bytes)?;
    let edges = rest.numbers(edges.checked_mul(4)?, f32::from_le_bytes)?;
    let window = |(&[x_px, y_px, salience], radius): (&[f32; 3], u8)| Window {
        point: InterestPoint { x_px, y_px, salience },
        radius,
    };
    let edge =
        |&[x_px, y_px, gradient_x, gradient_y]: &[f32; 4]| EdgePoint { x_px, y_px, gradient_x, gradient_y };
    rest.0.is_empty().then(|| DescribedExemplar {
        exemplar: Exemplar {
            id: row.id.to_string(),
            label: row.label.clone(),
            width_px: row.width_px,
            height_px: row.height_px,
            windows,
            edges: edges.as_chunks().0.iter().map(edge).collect(),
        },
        windows: points.as_chunks().0.iter().zip(radii).map(window).collect(),
        colour: colour == 1,
        signatures: signatures.iter().map(|&number| f32::from(number) * unit).collect(),
        spectra,
    })
}

/// What isn't read yet.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    /// The next numbers; `None` if there are fewer.
    fn numbers<T, const N: usize>(&mut self, count: usize, value: fn([u8; N]) -> T) -> Option<Vec<T>> {
        let (taken, rest) = self.0.split_at_checked(count.checked_mul(N)?)?;
        self.0 = rest;
        Some(taken.as_chunks().0.iter().map(|&bytes| value(bytes)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::Timestamp;
    use landmarkd_core::imaging::{Frame, Image};
    use landmarkd_core::recognition::landmarks::{Colour, ExemplarName, Operator, describe};
    use uuid::Uuid;

    fn row() -> ExemplarRow {
        ExemplarRow {
            database: "d".into(),
            id: Uuid::nil(),
            label: "hall".into(),
            negative: false,
            pose_deg: None,
            survey: None,
            width_px: 160,
            height_px: 120,
            bytes: 1,
            sha256: String::new(),
            blob: BlobName::of(b"picture").to_string(),
            media_type: "image/png".into(),
            robot_id: None,
            frame_id: None,
            stamp: None,
            created_at: Timestamp::UNIX_EPOCH,
        }
    }

    fn described(options: &LandmarkOptions) -> DescribedExemplar {
        let plane = |seed: usize| {
            Image::from_fn(160, 120, |x, y| ((x / 7 * 131 + y / 5 * (31 + seed)) * 2_654_435 % 251) as f32)
        };
        let name = ExemplarName { id: row().id.to_string(), label: row().label };
        describe(name, &Frame::colour([plane(0), plane(1), plane(2)]), options)
    }

    #[test]
    fn a_description_comes_back_with_signatures_in_small_steps() {
        let fresh = described(&LandmarkOptions::default());
        assert!(fresh.windows.len() > 100 && fresh.colour);
        let bytes = encode(&fresh);
        let kept = decode(&bytes, &row()).unwrap();
        let largest = fresh.signatures.iter().fold(0.0_f32, |most, number| most.max(number.abs()));
        for (kept, fresh) in kept.signatures.iter().zip(&fresh.signatures) {
            assert!((kept - fresh).abs() <= 0.51 * largest / STEPS, "{kept} for {fresh}");
        }
        let signatures = fresh.signatures.clone();
        assert_eq!(DescribedExemplar { signatures, ..kept }, fresh);
    }

    #[test]
    fn a_picture_with_nothing_in_it_comes_back() {
        let name = ExemplarName { id: row().id.to_string(), label: row().label };
        let flat = Frame::gray(Image::from_fn(160, 120, |_, _| 7.0));
        let fresh = describe(name, &flat, &LandmarkOptions::default());
        assert_eq!(decode(&encode(&fresh), &row()).unwrap(), fresh);
    }

    #[test]
    fn what_is_cut_off_or_longer_is_none() {
        let bytes = encode(&described(&LandmarkOptions { interest_points: 4, ..LandmarkOptions::default() }));
        for end in 0..bytes.len() {
            assert!(decode(&bytes[..end], &row()).is_none(), "{end} of {}", bytes.len());
        }
        assert!(decode(&[&bytes[..], &[0]].concat(), &row()).is_none());
        assert!(decode(&[0xff; 400], &row()).is_none());
    }

    #[test]
    fn other_pictures_and_other_options_of_describing_have_other_keys() {
        let options = LandmarkOptions::default;
        let key = |options: &LandmarkOptions| description_key(&row(), options).unwrap();
        let same = LandmarkOptions { false_alarms: 0.5, query_points: 7, dimension: 9, ..options() };
        assert_eq!(key(&same), key(&options()));
        for other in [
            LandmarkOptions { operator: Operator::Harris, ..options() },
            LandmarkOptions { symmetry_radius_px: 7, ..options() },
            LandmarkOptions { interest_points: 7, ..options() },
            LandmarkOptions { subwindow_radii_px: vec![9.0], ..options() },
            LandmarkOptions { colour: Colour::Gray, ..options() },
            LandmarkOptions { working_size_px: None, ..options() },
            LandmarkOptions { levels_per_octave: 3, ..options() },
        ] {
            assert_ne!(key(&other), key(&options()), "{other:?}");
        }
        let picture = ExemplarRow { blob: BlobName::of(b"other").to_string(), ..row() };
        assert_ne!(description_key(&picture, &options()).unwrap(), key(&options()));
    }
}
