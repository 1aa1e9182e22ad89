//! Content negotiation: which of the types we can give the client asked for.

use axum::http::{HeaderMap, header};

use super::problem::{Code, Problem};

/// The best of `offered` (first = ours by preference) for the request's `Accept`; the first when there is none.
///
/// # Errors
/// 406 with the list when none is accepted.
pub fn choose(headers: &HeaderMap, offered: &[&'static str]) -> Result<&'static str, Problem> {
    let accepted: Vec<(String, f32)> = headers
        .get_all(header::ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .filter_map(range)
        .collect();
    if accepted.is_empty() {
        return Ok(offered[0]);
    }
    let quality = |offer: &str| {
        // RFC 9110 12.5.1: the most specific range decides, whatever its quality.
        let specific = accepted.iter().find(|(range, _)| range == offer);
        let family = || {
            let kind = offer.split('/').next().unwrap_or_default();
            accepted.iter().find(|(range, _)| range.strip_suffix("/*") == Some(kind))
        };
        let any = || accepted.iter().find(|(range, _)| range == "*/*");
        specific.or_else(family).or_else(any).map_or(0.0, |(_, quality)| *quality)
    };
    let mut best = (0.0, None);
    for &offer in offered {
        let quality = quality(offer);
        if quality > best.0 {
            best = (quality, Some(offer));
        }
    }
    best.1.ok_or_else(|| {
        Problem::new(
            Code::NotAcceptable,
            format!("this call gives {}: accept one of them", offered.join(", ")),
        )
    })
}

/// One range of an Accept header and its quality.
fn range(text: &str) -> Option<(String, f32)> {
    let mut parts = text.split(';').map(str::trim);
    let range = parts.next().filter(|range| range.contains('/'))?.to_ascii_lowercase();
    let quality = parts.find_map(|part| part.strip_prefix("q=")?.parse().ok()).unwrap_or(1.0);
    Some((range, quality))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(accept: &str) -> Result<&'static str, Code> {
        let headers = HeaderMap::from_iter([(header::ACCEPT, accept.parse().unwrap())]);
        choose(&headers, &["application/json", "image/png"]).map_err(|problem| problem.code)
    }

    #[test]
    fn the_client_chooses_and_we_break_ties() {
        assert_eq!(choose(&HeaderMap::new(), &["application/json"]).unwrap(), "application/json");
        assert_eq!(chosen("*/*"), Ok("application/json"));
        assert_eq!(chosen("image/png"), Ok("image/png"));
        assert_eq!(chosen("image/*"), Ok("image/png"));
        assert_eq!(chosen("application/json;q=0.5, image/png"), Ok("image/png"));
        assert_eq!(chosen("image/png;q=0, */*"), Ok("application/json"));
        assert_eq!(chosen("text/html"), Err(Code::NotAcceptable));
    }
}
