//! Content negotiation (RFC 9110, 12): the media type that the client prefers of those that a call gives.

use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;

use super::problem::{Code, Problem};

/// The best of `offered` (the service's preference first) for the request's `Accept`; the first when there is none. An
/// offer may have parameters: `image/png; preview=turbo`.
///
/// # Errors
/// 406 with the list when none is accepted.
pub fn choose(headers: &HeaderMap, offered: &[&'static str]) -> Result<&'static str, Problem> {
    let offers: Vec<MediaType> = offered.iter().filter_map(|offer| MediaType::read(offer)).collect();
    let accepted: Vec<(MediaType, f32)> = headers
        .get_all(header::ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .filter_map(|text| range(text, &offers))
        .collect();
    if accepted.is_empty() {
        return Ok(offered[0]);
    }
    let mut best = (0.0, None);
    for (&text, offer) in offered.iter().zip(&offers) {
        // RFC 9110 12.5.1: the most specific range decides, whatever its quality.
        let matching = accepted.iter().rev().filter(|(range, _)| range.takes(offer));
        let quality = matching.max_by_key(|(range, _)| range.specificity()).map_or(0.0, |(_, q)| *q);
        if quality > best.0 {
            best = (quality, Some(text));
        }
    }
    best.1.ok_or_else(|| {
        Problem::new(
            Code::NotAcceptable,
            format!("this call gives {}: accept one of them", offered.join(", ")),
        )
    })
}

/// The response, marked as one that depends on `Accept`.
pub fn vary(mut response: Response) -> Response {
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    response
}

/// A media type or a range of them, with its parameters, in lower case.
#[derive(Debug, PartialEq, Eq)]
struct MediaType {
    /// `image/png`, `image/*` or `*/*`.
    essence: String,
    parameters: Vec<(String, String)>,
}

impl MediaType {
    /// None for text that is no media type.
    fn read(text: &str) -> Option<Self> {
        let mut parts = text.split(';').map(|part| part.trim().to_ascii_lowercase());
        let essence = parts.next().filter(|essence| essence.contains('/'))?;
        let parameter = |part: String| {
            let (name, value) = part.split_once('=')?;
            Some((name.trim().to_owned(), value.trim().trim_matches('"').to_owned()))
        };
        Some(Self { essence, parameters: parts.filter_map(parameter).collect() })
    }

    /// Whether this range holds the offer.
    fn takes(&self, offer: &Self) -> bool {
        let family = self.essence.strip_suffix("/*");
        let essence = family.map_or(self.essence == offer.essence, |family| {
            family == "*" || offer.essence.split('/').next() == Some(family)
        });
        essence && self.parameters.iter().all(|parameter| offer.parameters.contains(parameter))
    }

    /// Grows the fewer types a range holds.
    fn specificity(&self) -> (usize, usize) {
        let level = match self.essence.as_str() {
            "*/*" => 0,
            essence if essence.ends_with("/*") => 1,
            _ => 2,
        };
        (level, self.parameters.len())
    }
}

/// One range of an Accept header and its quality. Parameters of a name that no offer has are let be: `charset=utf-8`
/// refuses nobody's JSON.
fn range(text: &str, offers: &[MediaType]) -> Option<(MediaType, f32)> {
    let mut range = MediaType::read(text)?;
    let quality = range.parameters.iter().find(|(name, _)| name == "q");
    let quality = quality.and_then(|(_, value)| value.parse().ok()).unwrap_or(1.0);
    let known =
        |name: &str| offers.iter().flat_map(|offer| &offer.parameters).any(|(known, _)| known == name);
    range.parameters.retain(|(name, _)| known(name));
    Some((range, quality))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen_of(offered: &[&'static str], accept: &str) -> Result<&'static str, Code> {
        let headers = HeaderMap::from_iter([(header::ACCEPT, accept.parse().unwrap())]);
        choose(&headers, offered).map_err(|problem| problem.code)
    }

    #[test]
    fn the_client_chooses_and_we_break_ties() {
        assert_eq!(choose(&HeaderMap::new(), &["application/json"]).unwrap(), "application/json");
        let chosen = |accept: &str| chosen_of(&["application/json", "image/png"], accept);
        assert_eq!(chosen("*/*"), Ok("application/json"));
        assert_eq!(chosen("image/png"), Ok("image/png"));
        assert_eq!(chosen("image/*"), Ok("image/png"));
        assert_eq!(chosen("application/json;q=0.5, image/png"), Ok("image/png"));
        assert_eq!(chosen("image/png;q=0, */*"), Ok("application/json"));
        assert_eq!(chosen("text/html"), Err(Code::NotAcceptable));
        assert_eq!(chosen("application/json; charset=utf-8"), Ok("application/json"));
        assert_eq!(chosen("image/PNG, image/png;q=0"), Ok("image/png"), "of equal ranges the first counts");
    }

    #[test]
    fn a_parameter_chooses_the_offer_that_has_it_and_no_other() {
        let chosen =
            |accept: &str| chosen_of(&["application/json", "image/png", "image/png; preview=turbo"], accept);
        assert_eq!(chosen("image/png"), Ok("image/png"));
        assert_eq!(chosen("image/*"), Ok("image/png"));
        for preview in [
            "image/png; preview=turbo",
            "image/png;preview=\"turbo\"",
            "Image/PNG ; Preview=Turbo;q=0.3",
            "image/png;preview=turbo, image/png;q=0.9",
            "image/png;q=0.1, image/png;preview=turbo;q=0.2",
        ] {
            assert_eq!(chosen(preview), Ok("image/png; preview=turbo"), "{preview}");
        }
        assert_eq!(chosen("image/png;preview=turbo;q=0.5, image/png"), Ok("image/png"));
        assert_eq!(chosen("image/png;preview=grey"), Err(Code::NotAcceptable));
        assert_eq!(chosen("image/png;preview=grey, */*;q=0.1"), Ok("application/json"));
    }
}
