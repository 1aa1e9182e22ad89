//! How well a version knows its own pictures, in words and numbers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use landmarkd_core::recognition::landmarks::LeftOut;

/// Labels and pairs that are listed at most.
const MOST_LISTED: usize = 100;
/// Names that a sentence holds at most.
const MOST_NAMED: usize = 5;

/// What the version said of its own pictures, each with itself left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = VerdictBody)]
pub struct VerdictReport {
    /// In a sentence.
    pub summary: String,
    /// What would help; null if nothing is wanting.
    pub remedy: Option<String>,
    /// Pictures that were asked and whose label has others.
    pub asked: u64,
    /// Of these, the ones that were named rightly by the others.
    pub named: u64,
    /// Labels with one picture among those that were asked: nothing tells how they do.
    pub single_picture_labels: Vec<String>,
    /// Labels that show the same.
    pub alike: Vec<AlikeReport>,
    /// Exemplars that are one picture under two labels: the label, and the id of the other's exemplar.
    pub same_pictures: Vec<SamePictureReport>,
}

/// Two labels that show the same.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = AlikeBody)]
pub struct AlikeReport {
    // Both labels, in their order.
    pub labels: [String; 2],
    /// Pictures of either that the other explains.
    pub pictures: u64,
}

/// One picture under two labels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = SamePictureBody)]
pub struct SamePictureReport {
    /// One of the labels.
    pub label: String,
    /// Id of the other's exemplar.
    pub exemplar: String,
}

impl VerdictReport {
    /// Of what was said of each picture.
    pub fn of(left_out: &[LeftOut]) -> Self {
        let others: Vec<&LeftOut> = left_out.iter().filter(|picture| picture.has_others).collect();
        let named = others.iter().filter(|picture| picture.named).count();
        let single =
            left_out.iter().filter(|picture| !picture.has_others).map(|picture| picture.label.clone());
        let mut pairs: BTreeMap<[String; 2], u64> = BTreeMap::new();
        for picture in left_out {
            for other in &picture.alike {
                let mut labels = [picture.label.clone(), other.clone()];
                labels.sort();
                *pairs.entry(labels).or_default() += 1;
            }
        }
        let mut alike: Vec<AlikeReport> =
            pairs.into_iter().map(|(labels, pictures)| AlikeReport { labels, pictures }).collect();
        alike.sort_by_key(|pair| std::cmp::Reverse(pair.pictures)); // stable
        let same = left_out.iter().filter_map(|picture| {
            let exemplar = picture.same_picture.clone()?;
            Some(SamePictureReport { label: picture.label.clone(), exemplar })
        });
        let mut verdict = Self {
            summary: String::new(),
            remedy: None,
            asked: others.len() as u64,
            named: named as u64,
            single_picture_labels: single.take(MOST_LISTED).collect(),
            alike,
            same_pictures: same.take(MOST_LISTED).collect(),
        };
        verdict.alike.truncate(MOST_LISTED);
        verdict.summary = verdict.in_a_sentence();
        verdict.remedy = verdict.what_would_help();
        verdict
    }

    fn in_a_sentence(&self) -> String {
        let single = self.single_picture_labels.len();
        let known = match self.asked {
            0 => "every label has one picture, so nothing tells how well others of it are recognised"
                .to_owned(),
            asked => {
                format!("{} of {asked} pictures are recognised by the others of their label", self.named)
            }
        };
        let singles = match single {
            0 => String::new(),
            1 if self.asked > 0 => "; 1 label has one picture".to_owned(),
            _ if self.asked > 0 => format!("; {single} labels have one picture"),
            _ => String::new(),
        };
        let alike = match self.alike.len() {
            0 => String::new(),
            1 => "; 1 pair of labels shows the same".to_owned(),
            pairs => format!("; {pairs} pairs of labels show the same"),
        };
        format!("{known}{singles}{alike}")
    }

    fn what_would_help(&self) -> Option<String> {
        let mut remedies = Vec::new();
        if let Some(same) = self.same_pictures.first() {
            remedies.push(format!(
                "one picture is taught as {:?} and again under another label (exemplar {}): delete one",
                same.label, same.exemplar
            ));
        }
        if let Some(AlikeReport { labels: [a, b], .. }) = self.alike.first() {
            remedies.push(format!("{a:?} and {b:?} show the same: merge them, or take other views"));
        }
        if !self.single_picture_labels.is_empty() {
            let named: Vec<String> = self
                .single_picture_labels
                .iter()
                .take(MOST_NAMED)
                .map(|label| format!("{label:?}"))
                .collect();
            let more = if self.single_picture_labels.len() > MOST_NAMED { " and others" } else { "" };
            remedies.push(format!("take a second picture, from elsewhere, of {}{more}", named.join(", ")));
        } else if self.named < self.asked {
            remedies.push("take more pictures of what isn't recognised, from between the others".to_owned());
        }
        (!remedies.is_empty()).then(|| remedies.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(label: &str, has_others: bool, named: bool, alike: &[&str]) -> LeftOut {
        LeftOut {
            label: label.into(),
            has_others,
            named,
            alike: alike.iter().map(|&label| label.into()).collect(),
            same_picture: None,
        }
    }

    #[test]
    fn a_verdict_says_what_is_known_and_what_would_help() {
        let verdict = VerdictReport::of(&[
            picture("hall", true, true, &[]),
            picture("hall", true, false, &["stairs"]),
            picture("stairs", false, false, &["hall"]),
        ]);
        assert_eq!(
            verdict.summary,
            "1 of 2 pictures are recognised by the others of their label; 1 label has one picture; 1 pair of labels shows the same"
        );
        let remedy = verdict.remedy.unwrap();
        assert!(remedy.contains("\"hall\" and \"stairs\" show the same"), "{remedy}");
        assert!(remedy.contains("a second picture, from elsewhere, of \"stairs\""), "{remedy}");
        assert_eq!(verdict.alike, [AlikeReport { labels: ["hall".into(), "stairs".into()], pictures: 2 }]);
    }

    #[test]
    fn where_all_is_well_nothing_would_help() {
        let verdict =
            VerdictReport::of(&[picture("hall", true, true, &[]), picture("hall", true, true, &[])]);
        assert_eq!((verdict.asked, verdict.named, verdict.remedy), (2, 2, None));
    }
}
