//! The two pictures that depth is measured from, as parts of a form: `near` and `far`, of two focus settings; or `wide` and
//! `narrow`, of two apertures.

use bytes::Bytes;

use super::problem::{FieldError, Problem};
use super::uploads::{KnownParts, Picture};
use landmarkd_core::depth::{FocalPair, Optics};
use landmarkd_core::imaging::{self, DecodeLimits};

/// The parts of both kinds of pair.
pub const PAIR_PARTS: [&str; 4] = ["near", "far", "wide", "narrow"];

/// Two parts of a form, by their names.
pub struct PairParts([(&'static str, Bytes); 2]);

/// Two pictures in the order of their optics, under the names of their parts.
pub struct PairPictures([(&'static str, Picture); 2]);

impl PairParts {
    /// The pair in a form; a fault for each picture that is missing, or of the other kind.
    pub fn take(parts: &mut KnownParts) -> Option<Self> {
        let of_apertures = (parts.holds("wide") || parts.holds("narrow")) && !parts.holds("near");
        let [names, others] = match of_apertures {
            true => [["wide", "narrow"], ["near", "far"]],
            false => [["near", "far"], ["wide", "narrow"]],
        };
        let [first, second] = names.map(|name| parts.require(name));
        for other in others {
            if parts.take(other).is_some() {
                let detail = format!("is no part beside {} and {}: send one pair", names[0], names[1]);
                parts.faults.push(FieldError { pointer: format!("/{other}"), detail });
            }
        }
        first.zip(second).map(|(first, second)| Self([(names[0], first), (names[1], second)]))
    }

    /// The pictures, if they are those of this optics and may be measured.
    ///
    /// # Errors
    /// A pair of the other kind, or a picture that is none or is too large.
    pub fn pictures(self, optics: &Optics, limits: &DecodeLimits) -> Result<PairPictures, Problem> {
        let names = optics.picture_names();
        let [a, b] = self.0;
        if !names.contains(&a.0) {
            let detail = format!(
                "is no picture of these optics: their pictures differ in {}, send {} and {}",
                if names.contains(&"near") { "focus" } else { "aperture" },
                names[0],
                names[1]
            );
            return Err(Problem::field(format!("/{}", a.0), detail));
        }
        PairPictures::of(if a.0 == names[0] { [a, b] } else { [b, a] }, limits)
    }
}

/// A picture for depth in the part of that name.
///
/// # Errors
/// No picture, or one that is too large.
pub fn depth_picture(name: &str, bytes: Bytes, limits: &DecodeLimits) -> Result<Picture, Problem> {
    Picture::of(bytes, limits).and_then(Picture::for_depth).map_err(|problem| problem.in_part(name))
}

impl PairPictures {
    /// The pictures in these parts, which are in the order of their optics.
    ///
    /// # Errors
    /// As of [`depth_picture`].
    pub fn of([first, second]: [(&'static str, Bytes); 2], limits: &DecodeLimits) -> Result<Self, Problem> {
        let of = |(name, bytes)| Ok::<_, Problem>((name, depth_picture(name, bytes, limits)?));
        Ok(Self([of(first)?, of(second)?]))
    }

    /// The name of the first one's part.
    pub fn first_name(&self) -> &'static str {
        self.0[0].0
    }

    /// The pair, decoded: for a computing thread.
    ///
    /// # Errors
    /// A picture that can't be decoded, or two that are no pair.
    pub fn decoded(&self, limits: &DecodeLimits) -> Result<FocalPair, Problem> {
        let [first, second] = &self.0;
        let decoded = |(name, picture): &(&'static str, Picture)| {
            imaging::decode(&picture.bytes, limits).map_err(|error| Problem::from(error).in_part(name))
        };
        let bits = first.1.bits.min(second.1.bits);
        Ok(FocalPair::new(decoded(first)?, decoded(second)?, bits)?)
    }

    /// Memory that they take while they are measured.
    pub fn depth_bytes(&self) -> u64 {
        self.0.iter().map(|(_, picture)| picture.depth_bytes).sum()
    }
}
