//! `If-Match` and `If-None-Match` (RFC 9110, 13.1): lists of entity tags, or `*` for whatever is there.

use axum::http::HeaderMap;
use axum::http::header::HeaderName;

use super::problem::{Code, Problem};

/// The entity tags of a precondition.
#[derive(Debug, PartialEq, Eq)]
pub enum Tags {
    /// `*`
    Any,
    /// Each with its quotes; weak ones keep their `W/`.
    Listed(Vec<String>),
}

impl Tags {
    /// Those of a header, all its lines together; `None` when it isn't sent.
    ///
    /// # Errors
    /// 400 for anything else than `*` or quoted tags with commas between them.
    pub fn of(headers: &HeaderMap, name: HeaderName) -> Result<Option<Self>, Problem> {
        let lines = headers.get_all(&name).iter().map(|value| value.to_str().ok());
        let Some(lines) = lines.collect::<Option<Vec<_>>>() else { return Err(wrong(&name)) };
        if lines.is_empty() {
            return Ok(None);
        }
        let text = lines.join(",");
        match text.trim() {
            "*" => Ok(Some(Self::Any)),
            text => listed(text).map(|tags| Some(Self::Listed(tags))).ok_or_else(|| wrong(&name)),
        }
    }

    /// Strong comparison, for changes: whether one of them is this tag; a weak one never is.
    pub fn matches(&self, tag: &str) -> bool {
        match self {
            Self::Any => true,
            Self::Listed(tags) => tags.iter().any(|listed| listed == tag),
        }
    }

    /// Weak comparison, for copies that the caller has: whether one of them is this tag, weak or not.
    pub fn matches_weakly(&self, tag: &str) -> bool {
        match self {
            Self::Any => true,
            Self::Listed(tags) => tags.iter().any(|listed| listed.trim_start_matches("W/") == tag),
        }
    }
}

fn wrong(name: &HeaderName) -> Problem {
    let text = format!("{name} must be * or ETags as GET gives them, quoted, with commas between them");
    Problem::new(Code::MalformedRequest, text)
}

/// Quoted tags with commas between them: a comma may stand in a tag too.
fn listed(text: &str) -> Option<Vec<String>> {
    let mut tags = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start_matches([' ', '\t', ',']);
        if rest.is_empty() {
            return (!tags.is_empty()).then_some(tags);
        }
        let start = if rest.starts_with("W/") { 2 } else { 0 };
        let length = rest[start..].strip_prefix('"')?.find('"')? + start + 2;
        tags.push(rest[..length].to_owned());
        rest = rest[length..].trim_start_matches([' ', '\t']);
        if !rest.is_empty() && !rest.starts_with(',') {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::header::IF_MATCH;

    fn of(lines: &[&str]) -> Result<Option<Tags>, Code> {
        let headers = lines.iter().map(|line| (IF_MATCH, line.parse().unwrap())).collect();
        Tags::of(&headers, IF_MATCH).map_err(|problem| problem.code)
    }

    #[test]
    fn tags_are_listed_weak_or_strong_in_one_line_or_several() {
        assert_eq!(of(&[]), Ok(None));
        assert_eq!(of(&[" * "]), Ok(Some(Tags::Any)));
        let tags = of(&["\"1\", W/\"2\",, \"a,b\"", "\"\""]).unwrap().unwrap();
        for (tag, strongly, weakly) in [
            ("\"1\"", true, true),
            ("\"2\"", false, true),
            ("\"a,b\"", true, true),
            ("\"\"", true, true),
            ("\"3\"", false, false),
        ] {
            assert_eq!((tags.matches(tag), tags.matches_weakly(tag)), (strongly, weakly), "{tag}");
        }
    }

    #[test]
    fn what_is_no_list_of_tags_is_malformed() {
        for bad in ["", ",", "1", "\"1", "\"1\" \"2\"", "W/1", "\"1\", *", "w/\"1\"", "\"1\"x"] {
            assert_eq!(of(&[bad]), Err(Code::MalformedRequest), "{bad}");
        }
    }
}
